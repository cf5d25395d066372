//! Shaders, linked by name.
//!
//! The source of a pass is a generated header, the slot files that it names, and its own file. The
//! header holds everything that Rust decides: the scalar type, constants, parameter blocks and the
//! buffers with their binding numbers. The bind group layout is made from the same list.

use std::fmt::Write;

use include_dir::{Dir, include_dir};

use super::{GpuError, Real};

static SHADERS: Dir<'static> = include_dir!("$CARGO_MANIFEST_DIR/shaders");

/// The elements of a storage buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// u32.
    U32,
    /// atomic u32.
    AtomicU32,
    /// [`Real`].
    Real,
    /// Two [`Real`]s.
    Real2,
    /// Four [`Real`]s.
    Real4,
    /// Four u32s.
    U32x4,
}

/// A parameter block: first counts (u32), then reals, without gaps but for the alignment of the
/// first real. One definition makes both the WGSL struct and its bytes.
#[derive(Debug, PartialEq, Eq)]
pub struct BlockLayout {
    /// The name of the WGSL struct.
    pub name: &'static str,
    /// The names of the counts.
    pub counts: &'static [&'static str],
    /// The names of the reals.
    pub reals: &'static [&'static str],
}

impl BlockLayout {
    /// The offset of the first real, bytes.
    pub fn reals_offset(&self, real: Real) -> usize {
        (4 * self.counts.len()).next_multiple_of(real.size())
    }

    /// The size, bytes.
    pub fn size(&self, real: Real) -> usize {
        let alignment = if self.reals.is_empty() { 4 } else { real.size() };
        let end = match self.reals.len() {
            0 => 4 * self.counts.len(),
            reals => self.reals_offset(real) + reals * real.size(),
        };
        end.next_multiple_of(alignment)
    }

    /// The WGSL struct.
    pub fn declaration(&self) -> String {
        let counts = self.counts.iter().map(|name| format!("    {name}: u32,\n"));
        let reals = self.reals.iter().map(|name| format!("    {name}: real,\n"));
        let members: String = counts.chain(reals).collect();
        format!("struct {} {{\n{members}}}\n", self.name)
    }

    /// The bytes of a block with these values, in the order of the names.
    pub fn contents<const C: usize, const R: usize>(
        &self,
        real: Real,
        counts: [u32; C],
        reals: [f64; R],
    ) -> Vec<u8> {
        debug_assert_eq!((C, R), (self.counts.len(), self.reals.len()));
        let mut bytes = bytemuck::cast_slice(&counts).to_vec();
        bytes.resize(self.reals_offset(real), 0);
        bytes.extend(real.to_bytes(&reals));
        bytes.resize(self.size(real), 0);
        bytes
    }
}

/// What a buffer of a pass holds, and whether the pass writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// A parameter block.
    Block(&'static BlockLayout),
    /// An array that the pass reads.
    Read(Element),
    /// An array that the pass reads and writes.
    Write(Element),
}

/// A buffer of a pass: its name in the shader and what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// The name in the shader.
    pub name: &'static str,
    /// What it holds.
    pub holds: Holds,
}

impl Binding {
    /// A buffer called `name` that holds `holds`.
    pub const fn new(name: &'static str, holds: Holds) -> Self {
        Self { name, holds }
    }

    fn declaration(&self, number: usize) -> String {
        let element = |element| match element {
            Element::U32 => "u32",
            Element::AtomicU32 => "atomic<u32>",
            Element::Real => "real",
            Element::Real2 => "vec2<real>",
            Element::Real4 => "vec4<real>",
            Element::U32x4 => "vec4<u32>",
        };
        let (space, of) = match self.holds {
            Holds::Block(layout) => ("uniform", layout.name.to_owned()),
            Holds::Read(e) => ("storage, read", format!("array<{}>", element(e))),
            Holds::Write(e) => ("storage, read_write", format!("array<{}>", element(e))),
        };
        format!("@group(0) @binding({number}) var<{space}> {}: {of};\n", self.name)
    }
}

/// A constant of the generated header.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Constant {
    /// u32.
    Count(u32),
    /// bool.
    Flag(bool),
    /// [`Real`].
    Real(f64),
}

/// Everything that the source of a pass follows from.
#[derive(Clone, Debug, PartialEq)]
pub struct PassSource {
    /// The stem of its file in `shaders/pass`, and its name in messages.
    pub pass: &'static str,
    /// What `real` means.
    pub real: Real,
    /// Invocations a workgroup.
    pub workgroup_size: u32,
    /// Constants by name.
    pub constants: Vec<(&'static str, Constant)>,
    /// Buffers, in the order of their binding numbers.
    pub bindings: Vec<Binding>,
    /// Slot files, relative to `shaders/` and without the ending.
    pub slots: Vec<String>,
    /// Functions that follow from numbers of the scene, which come after the slots.
    pub generated: String,
}

impl PassSource {
    /// The final source.
    pub fn link(&self) -> Result<String, GpuError> {
        let mut source = self.header();
        source.push_str(self.file("index")?);
        for slot in &self.slots {
            source.push_str(self.file(slot)?);
        }
        source.push_str(&self.generated);
        source.push_str(self.file(&format!("pass/{}", self.pass))?);
        Ok(source)
    }

    fn file(&self, stem: &str) -> Result<&'static str, GpuError> {
        let file = format!("{stem}.wgsl");
        let text = SHADERS.get_file(&file).and_then(|f| f.contents_utf8());
        text.ok_or_else(|| GpuError::MissingShader { pass: self.pass.to_owned(), file })
    }

    fn header(&self) -> String {
        let mut text = format!("alias real = {};\n", self.real.name());
        let size = Constant::Count(self.workgroup_size);
        for (name, value) in [("WORKGROUP_SIZE", size)].iter().chain(&self.constants) {
            let (of, literal) = match *value {
                Constant::Count(count) => ("u32", format!("{count}u")),
                Constant::Flag(flag) => ("bool", flag.to_string()),
                Constant::Real(real) => ("real", self.real.literal(real)),
            };
            // Writing to a String cannot fail.
            let _ = writeln!(text, "const {name}: {of} = {literal};");
        }
        for binding in &self.bindings {
            if let Holds::Block(layout) = binding.holds {
                text.push_str(&layout.declaration());
            }
        }
        for (number, binding) in self.bindings.iter().enumerate() {
            text.push_str(&binding.declaration(number));
        }
        text
    }
}
