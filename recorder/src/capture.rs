//! Carries arrays from a backend to the dump: a bounded ring of buffers and a thread that writes.

use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, channel, sync_channel};
use std::thread::JoinHandle;

use anyhow::{Context, Result, anyhow};
use formats::manifest::{End, Place, Record};
use formats::npy::{Dtype, Element};
use formats::writer::{DumpWriter, WriteError};

/// Buffers that may wait for the disk: with [`BUFFER_BYTES`] each, what capture adds to memory.
const BUFFERS: usize = 64;
/// Bytes of a buffer.
pub const BUFFER_BYTES: usize = 1 << 20;

enum Message {
    Begin(Place, Dtype, Vec<u64>),
    Bytes(Vec<u8>),
    FinishArray,
    Record(Record),
    /// Answered when everything before it is on the disk.
    Drain(SyncSender<()>),
    End(End),
}

/// Writes a dump while the backend goes on.
pub struct Capture {
    messages: Option<SyncSender<Message>>,
    used_buffers: Receiver<Vec<u8>>,
    buffers_made: usize,
    thread: Option<JoinHandle<Result<std::path::PathBuf, WriteError>>>,
}

impl Capture {
    /// Starts the thread that owns `writer`.
    ///
    /// # Errors
    /// If the system has no thread left.
    pub fn start(writer: DumpWriter) -> Result<Self> {
        let (messages, inbox) = sync_channel(BUFFERS);
        let (returns, used_buffers) = channel();
        let thread = std::thread::Builder::new()
            .name("capture".into())
            .spawn(move || write_all(writer, &inbox, |buffer| drop(returns.send(buffer))))
            .context("starting the capture thread")?;
        Ok(Self { messages: Some(messages), used_buffers, buffers_made: 0, thread: Some(thread) })
    }

    /// Writes one array; `fill` gets a sink for exactly its bytes.
    ///
    /// # Errors
    /// Any of `fill`, or what went wrong with writing up to now.
    pub fn array(
        &mut self,
        place: Place,
        dtype: Dtype,
        shape: &[u64],
        fill: impl FnOnce(&mut crate::backends::Sink<'_>) -> Result<()>,
    ) -> Result<()> {
        self.send(Message::Begin(place, dtype, shape.to_vec()))?;
        fill(&mut |bytes: &[u8]| self.send_bytes(bytes))?;
        self.send(Message::FinishArray)
    }

    /// Writes an array that is in memory already.
    ///
    /// # Errors
    /// What went wrong with writing up to now.
    pub fn whole_array<T: Element>(&mut self, place: Place, shape: &[u64], values: &[T]) -> Result<()> {
        self.array(place, T::DTYPE, shape, |sink| {
            bytemuck::cast_slice(values).chunks(BUFFER_BYTES).try_for_each(sink)
        })
    }

    /// Appends a record to the manifest.
    ///
    /// # Errors
    /// What went wrong with writing up to now.
    pub fn record(&mut self, record: Record) -> Result<()> {
        self.send(Message::Record(record))
    }

    /// Waits until all that was handed over is on the disk, so that nothing is written beside what is timed.
    ///
    /// # Errors
    /// What went wrong with writing up to now.
    pub fn drain(&mut self) -> Result<()> {
        let (done, is_done) = sync_channel(1);
        self.send(Message::Drain(done))?;
        is_done.recv().map_err(|_| self.failure())
    }

    /// Waits until all is on the disk and the dump has its name, which is returned.
    ///
    /// # Errors
    /// What went wrong with writing.
    pub fn finish(mut self, end: End) -> Result<std::path::PathBuf> {
        self.send(Message::End(end))?;
        self.messages = None;
        self.join()
    }

    fn send_bytes(&mut self, bytes: &[u8]) -> Result<()> {
        for piece in bytes.chunks(BUFFER_BYTES) {
            let mut buffer = self.buffer();
            buffer.clear();
            buffer.extend_from_slice(piece);
            self.send(Message::Bytes(buffer))?;
        }
        Ok(())
    }

    /// A used buffer if there is one, a new one while the ring is not full, else the next to return.
    fn buffer(&mut self) -> Vec<u8> {
        match self.used_buffers.try_recv() {
            Ok(buffer) => buffer,
            Err(TryRecvError::Empty) if self.buffers_made >= BUFFERS => {
                self.used_buffers.recv().unwrap_or_default()
            }
            Err(_) => {
                self.buffers_made += 1;
                Vec::with_capacity(BUFFER_BYTES)
            }
        }
    }

    fn send(&mut self, message: Message) -> Result<()> {
        let Some(messages) = &self.messages else {
            return Err(anyhow!("the recording has ended already"));
        };
        if messages.send(message).is_ok() {
            return Ok(());
        }
        Err(self.failure())
    }

    /// Why the thread stopped early: only on an error, which says more than a closed channel.
    fn failure(&mut self) -> anyhow::Error {
        self.messages = None;
        self.join().err().unwrap_or_else(|| anyhow!("the capture thread stopped early"))
    }

    fn join(&mut self) -> Result<std::path::PathBuf> {
        let thread = self.thread.take().ok_or_else(|| anyhow!("writing the recording failed before"))?;
        Ok(thread.join().map_err(|_| anyhow!("the capture thread panicked"))??)
    }
}

/// What was handed over before an error is written to its end, so that `recover` finds it.
impl Drop for Capture {
    fn drop(&mut self) {
        self.messages = None;
        if let Some(thread) = self.thread.take() {
            // The error that ended the recording is the one to be told.
            drop(thread.join());
        }
    }
}

fn write_all(
    mut writer: DumpWriter,
    inbox: &Receiver<Message>,
    give_back: impl Fn(Vec<u8>),
) -> Result<std::path::PathBuf, WriteError> {
    let target = writer.target().to_owned();
    while let Ok(message) = inbox.recv() {
        match message {
            Message::Begin(place, dtype, shape) => {
                let mut array = writer.array(&place, dtype, &shape)?;
                while let Ok(Message::Bytes(bytes)) = inbox.recv() {
                    array.write(&bytes)?;
                    give_back(bytes);
                }
                // Fails where the recording was given up within the array, which is removed then.
                array.finish()?;
            }
            Message::Record(record) => writer.record(&record)?,
            Message::Drain(done) => {
                writer.sync()?;
                // Whoever asked has given up only if the recording has.
                let _ = done.send(());
            }
            Message::End(end) => return writer.finish(end),
            // Both follow a `Begin`.
            Message::Bytes(_) | Message::FinishArray => {}
        }
    }
    // The recording was given up; what is complete stays in the partial folder.
    Ok(target)
}
