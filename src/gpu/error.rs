//! What can go wrong on a device.

/// A failure of the device, or a request that it cannot meet.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No adapter of that name, or none at all.
    #[error("{}", no_adapter(wanted.as_deref(), available))]
    NoAdapter {
        /// The part of a name that was asked for, if any.
        wanted: Option<String>,
        /// The names of the adapters that there are.
        available: Vec<String>,
    },
    /// The driver refused to open the device.
    #[error("adapter `{adapter}` could not be opened")]
    Open {
        /// The adapter's name.
        adapter: String,
        /// The driver's reason.
        source: wgpu::RequestDeviceError,
    },
    /// The adapter lacks a feature that was asked for.
    #[error("adapter `{adapter}` has no {feature}")]
    MissingFeature {
        /// What is missing.
        feature: &'static str,
        /// The adapter's name.
        adapter: String,
    },
    /// Something is larger than the device takes in one piece.
    #[error("{what} needs {needed} bytes, but the device takes {available} in one piece")]
    TooLarge {
        /// The name of the buffer.
        what: String,
        /// Bytes asked for.
        needed: u64,
        /// Bytes allowed.
        available: u64,
    },
    /// The device's memory is used up.
    #[error("the device has no memory left for {what} ({needed} bytes)")]
    OutOfMemory {
        /// What was being made.
        what: String,
        /// Bytes asked for.
        needed: u64,
    },
    /// A shader names a file that does not exist.
    #[error("pass `{pass}` names the shader file `{file}`, which does not exist")]
    MissingShader {
        /// The pass.
        pass: String,
        /// The file, relative to `shaders/`.
        file: String,
    },
    /// A pass was given another number of buffers than it declares.
    #[error("pass `{pass}` declares {declared} buffers but was given {given}")]
    BufferCount {
        /// The pass.
        pass: String,
        /// Buffers that it declares.
        declared: usize,
        /// Buffers that it was given.
        given: usize,
    },
    /// A pass needs more storage buffers than the adapter binds at once.
    #[error(
        "pass `{pass}` needs {needed} storage buffers, but the device binds {available} at once"
    )]
    TooManyBuffers {
        /// The pass.
        pass: String,
        /// Storage buffers that it declares.
        needed: u32,
        /// Storage buffers that it may have.
        available: u32,
    },
    /// The driver, or wgpu's validation, refused something.
    #[error("the device refused {what}: {reason}")]
    Refused {
        /// What was being made.
        what: String,
        /// Its message.
        reason: String,
    },
    /// The device was lost (reset, unplugged, or stopped by its driver).
    #[error("the device was lost: {reason}")]
    Lost {
        /// The driver's message.
        reason: String,
    },
    /// Waiting for the device failed.
    #[error("waiting for the device failed")]
    Wait(#[from] wgpu::PollError),
    /// A buffer could not be read back.
    #[error("{what} could not be read back")]
    Map {
        /// The name of the buffer.
        what: String,
    },
}

impl GpuError {
    /// Whether what was asked for does not exist here, so that another flag would help.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::NoAdapter { .. } | Self::MissingFeature { .. })
    }

    /// Whether what was asked for is larger than the device or what is left of its memory.
    pub fn is_lack_of_room(&self) -> bool {
        matches!(self, Self::TooLarge { .. } | Self::OutOfMemory { .. })
    }
}

fn no_adapter(wanted: Option<&str>, available: &[String]) -> String {
    let found = match available {
        [] => "none was found".to_owned(),
        names => format!("there is: {}", names.join(", ")),
    };
    match wanted {
        Some(name) => format!("no adapter has `{name}` in its name; {found}"),
        None => format!("no GPU adapter can be used; {found}"),
    }
}
