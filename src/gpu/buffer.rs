//! Buffers on the device.

use super::{Device, GpuError};

/// A buffer on the device that shaders can read and write.
#[derive(Clone, Debug)]
pub struct Buffer {
    pub(super) inner: wgpu::Buffer,
    name: String,
    bytes: u64,
}

/// wgpu takes no empty binding; one 64-bit scalar is the least that every shader accepts.
const LEAST_BYTES: u64 = 8;

impl Buffer {
    /// What messages call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of its contents.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }
}

impl Device {
    /// A storage buffer of `bytes` bytes (a multiple of 4), all zero.
    pub fn storage(&self, name: &str, bytes: u64) -> Result<Buffer, GpuError> {
        self.storage_for(name, bytes, wgpu::BufferUsages::empty())
    }

    /// The same, from whose first three words passes may take their workgroups: along x, y and z.
    pub fn storage_with_workgroups(&self, name: &str, bytes: u64) -> Result<Buffer, GpuError> {
        self.storage_for(name, bytes, wgpu::BufferUsages::INDIRECT)
    }

    fn storage_for(
        &self,
        name: &str,
        bytes: u64,
        more: wgpu::BufferUsages,
    ) -> Result<Buffer, GpuError> {
        let available = self.max_binding_bytes();
        if bytes > available {
            return Err(GpuError::TooLarge { what: name.to_owned(), needed: bytes, available });
        }
        let usage = wgpu::BufferUsages::STORAGE
            | wgpu::BufferUsages::COPY_DST
            | wgpu::BufferUsages::COPY_SRC;
        self.buffer(name, bytes, usage | more)
    }

    /// A storage buffer with these contents (a multiple of 4 bytes).
    pub fn storage_with(&self, name: &str, contents: &[u8]) -> Result<Buffer, GpuError> {
        let buffer = self.storage(name, contents.len() as u64)?;
        self.write(&buffer, contents)?;
        Ok(buffer)
    }

    /// A parameter block with these contents (a multiple of 4 bytes).
    pub fn block(&self, name: &str, contents: &[u8]) -> Result<Buffer, GpuError> {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let buffer = self.buffer(name, contents.len() as u64, usage)?;
        self.write(&buffer, contents)?;
        Ok(buffer)
    }

    /// Replaces the contents, after everything submitted so far.
    pub fn write(&self, buffer: &Buffer, contents: &[u8]) -> Result<(), GpuError> {
        self.scoped(&buffer.name, contents.len() as u64, || {
            self.queue().write_buffer(&buffer.inner, 0, contents);
        })
    }

    /// Reads the contents back, after everything submitted so far.
    pub fn read(&self, buffer: &Buffer) -> Result<Vec<u8>, GpuError> {
        let staging_usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let staging = self.buffer(&buffer.name, buffer.bytes, staging_usage)?;
        self.copy(&[(buffer, &staging)])?;
        let slice = staging.inner.slice(..);
        let (sender, receiver) = std::sync::mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |outcome| {
            // The receiver is gone only if the wait below failed, which is reported there.
            let _ = sender.send(outcome.is_ok());
        });
        self.wait_for_all()?;
        let map_error = || GpuError::Map { what: buffer.name.clone() };
        // Another thread may have polled the device and be about to make the call.
        if !receiver.recv().unwrap_or(false) {
            return Err(map_error());
        }
        let view = slice.get_mapped_range().map_err(|_| map_error())?;
        Ok(view[..buffer.bytes as usize].to_vec())
    }

    /// Copies each first buffer to the second, of the same size.
    pub fn copy(&self, pairs: &[(&Buffer, &Buffer)]) -> Result<(), GpuError> {
        self.scoped("a copy", 0, || {
            let mut encoder = self.raw().create_command_encoder(&Default::default());
            for (from, to) in pairs.iter().filter(|(from, _)| from.bytes > 0) {
                encoder.copy_buffer_to_buffer(&from.inner, 0, &to.inner, 0, from.bytes);
            }
            self.queue().submit([encoder.finish()]);
        })
    }

    fn buffer(
        &self,
        name: &str,
        bytes: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<Buffer, GpuError> {
        let available = self.raw().limits().max_buffer_size;
        if bytes > available {
            return Err(GpuError::TooLarge { what: name.to_owned(), needed: bytes, available });
        }
        let inner = self.scoped(name, bytes, || {
            self.raw().create_buffer(&wgpu::BufferDescriptor {
                label: Some(name),
                size: bytes.max(LEAST_BYTES),
                usage,
                mapped_at_creation: false,
            })
        })?;
        Ok(Buffer { inner, name: name.to_owned(), bytes })
    }
}
