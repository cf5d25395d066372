//! Exclusive prefix sum of u32.

use super::{Binding, Buffer, Constant, Device, Element, GpuError, Holds, Pass, PassSource, Real};

/// Invocations of a scan workgroup: within the least that WebGPU guarantees.
const WORKGROUP_SIZE: u32 = 256;

/// Elements that an invocation adds up by itself.
const SCAN_ITEMS: u32 = 4;

/// Elements that a workgroup scans.
pub const SCAN_BLOCK: u64 = (WORKGROUP_SIZE * SCAN_ITEMS) as u64;

/// Replaces a buffer of u32 by its exclusive prefix sums: element i becomes the sum of those
/// before it, modulo 2^32.
///
/// Blocks of [`SCAN_BLOCK`] elements are scanned one a workgroup; their sums are scanned in turn,
/// in as many levels as it takes, and added back.
#[derive(Debug)]
pub struct Scan {
    passes: Vec<Pass>,
    bytes: u64,
}

impl Scan {
    /// The scan of `values`, of which each element counts.
    pub fn new(device: &Device, values: &Buffer) -> Result<Self, GpuError> {
        let [block_source, add_source] = scan_sources();
        let mut levels = vec![values.clone()];
        let mut down = Vec::new();
        let mut up = Vec::new();
        let mut count = values.bytes() / 4;
        while count > 0 {
            let blocks = count.div_ceil(SCAN_BLOCK);
            let sums = device.storage("sums of scan blocks", 4 * blocks)?;
            let level = &levels[levels.len() - 1];
            let threads = blocks * u64::from(WORKGROUP_SIZE);
            down.push(device.pass(&block_source, &[level, &sums], threads)?);
            if blocks == 1 {
                break;
            }
            up.push(device.pass(&add_source, &[level, &sums], count)?);
            levels.push(sums);
            count = blocks;
        }
        down.extend(up.into_iter().rev());
        Ok(Self { passes: down, bytes: levels.iter().skip(1).map(Buffer::bytes).sum() })
    }

    /// The passes, in order.
    pub fn passes(&self) -> &[Pass] {
        &self.passes
    }

    /// Bytes of its own buffers.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

/// The sources of its two passes: the scan of blocks, and adding the scanned sums back.
pub fn scan_sources() -> [PassSource; 2] {
    let source = |pass, sums| PassSource {
        pass,
        real: Real::F32,
        workgroup_size: WORKGROUP_SIZE,
        constants: vec![("SCAN_ITEMS", Constant::Count(SCAN_ITEMS))],
        bindings: vec![
            Binding::new("values", Holds::Write(Element::U32)),
            Binding::new("sums", sums),
        ],
        slots: Vec::new(),
        generated: String::new(),
    };
    [
        source("scan_block", Holds::Write(Element::U32)),
        source("scan_add", Holds::Read(Element::U32)),
    ]
}
