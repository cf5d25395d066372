//! What a device can do at most: two passes of a known amount of work, to be timed.

use super::{
    Binding, BlockLayout, Buffer, Device, Element, GpuError, Holds, Pace, Pass, PassSource, Real,
};

/// Invocations a workgroup: within the least that WebGPU guarantees.
const WORKGROUP_SIZE: u32 = 256;

/// The largest array that is copied, bytes: far more than any cache holds.
const MOST_COPIED: u64 = 512 << 20;

/// Invocations of the arithmetic pass: enough to fill a large device.
const INVOCATIONS: u64 = 1 << 18;

/// Chains that an invocation works on, and links of each in a round (`pass/arithmetic.wgsl`).
const CHAINS: u64 = 8;
const LINKS: u64 = 4;

/// Operations of a fused multiplication and addition.
const FUSED: u64 = 2;

/// Dispatches in a submission at most.
const MOST_DISPATCHES: u64 = 1000;

/// How long the chains of the arithmetic pass are, and a link of them.
pub static CHAIN: BlockLayout =
    BlockLayout { name: "Chain", counts: &["rounds"], reals: &["factor", "addend"] };

/// A pass that does a known amount of work.
#[derive(Debug)]
pub struct LimitPass {
    device: Device,
    pass: Pass,
    amount: u64,
    pace: Pace,
}

/// Copies one array to another.
#[derive(Debug)]
pub struct Copy {
    /// The pass; its amount is in bytes, read and written.
    pub pass: LimitPass,
    /// The copy.
    pub after: Buffer,
}

/// Chains of x -> factor x + addend.
#[derive(Debug)]
pub struct Arithmetic {
    /// The pass; its amount is in operations, of which a link of a chain has two.
    pub pass: LimitPass,
    /// Four values of each invocation: a + b, where a and b are the ends of chains from a value x
    /// and from x + addend.
    pub ends: Buffer,
}

impl Copy {
    /// Of as large an array of `real` as the device binds, up to `most` bytes (less than which no
    /// cache is sure to be left behind).
    pub fn new(device: &Device, real: Real, most: u64) -> Result<Self, GpuError> {
        let element = 4 * real.size() as u64;
        let bytes = device.max_binding_bytes().min(most).min(MOST_COPIED) / element * element;
        let count = bytes / element;
        // No zeros, of which some devices keep less than all.
        let values: Vec<f64> = (0..4 * count).map(|i| 1.0 + (i % 8191) as f64).collect();
        let before = device.storage_with("what is copied", &real.to_bytes(&values))?;
        let after = device.storage("the copy", bytes)?;
        let [source, _] = limit_sources(real);
        let pass = device.pass(&source, &[&before, &after], count)?;
        Ok(Self { pass: LimitPass::new(device, pass, 2 * bytes), after })
    }
}

impl Arithmetic {
    /// Of `rounds` rounds of four links from `start` on, with this `factor` and `addend`.
    pub fn new(
        device: &Device,
        real: Real,
        rounds: u32,
        [start, factor, addend]: [f64; 3],
    ) -> Result<Self, GpuError> {
        // Every chain starts elsewhere, or one would do for all.
        let starts: Vec<f64> = (0..4 * INVOCATIONS).map(|i| start + (i % 1021) as f64).collect();
        let starts = device.storage_with("starts of chains", &real.to_bytes(&starts))?;
        let ends = device.storage("ends of chains", starts.bytes())?;
        let chain = device.block("chain", &CHAIN.contents(real, [rounds], [factor, addend]))?;
        let [_, source] = limit_sources(real);
        let pass = device.pass(&source, &[&chain, &starts, &ends], INVOCATIONS)?;
        let operations = INVOCATIONS * CHAINS * LINKS * FUSED * u64::from(rounds);
        Ok(Self { pass: LimitPass::new(device, pass, operations), ends })
    }
}

impl LimitPass {
    fn new(device: &Device, pass: Pass, amount: u64) -> Self {
        Self { device: device.clone(), pass, amount, pace: Pace::new(MOST_DISPATCHES) }
    }

    /// What it does when it runs once.
    pub fn amount(&self) -> u64 {
        self.amount
    }

    /// Runs it `count` times, and waits for the last.
    pub fn run(&mut self, count: u64) -> Result<(), GpuError> {
        let mut remaining = count;
        while remaining > 0 {
            let repetitions = self.pace.next(&self.device, remaining)?;
            let passes = (0..repetitions).map(|_| &self.pass);
            let submission = self.device.submit(passes)?;
            self.pace.submitted(submission, repetitions);
            remaining -= repetitions;
        }
        self.device.wait_for_all()
    }
}

/// The sources of the two passes: the copy and the arithmetic.
pub fn limit_sources(real: Real) -> [PassSource; 2] {
    let source = |pass, bindings| PassSource {
        pass,
        real,
        workgroup_size: WORKGROUP_SIZE,
        constants: Vec::new(),
        bindings,
        slots: Vec::new(),
        generated: String::new(),
    };
    let read = |name| Binding::new(name, Holds::Read(Element::Real4));
    let write = |name| Binding::new(name, Holds::Write(Element::Real4));
    let chain = Binding::new("chain", Holds::Block(&CHAIN));
    [
        source("copy", vec![read("before"), write("after")]),
        source("arithmetic", vec![chain, read("starts"), write("ends")]),
    ]
}
