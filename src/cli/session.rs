//! What every command shares: the common flags, the device, the clock, warnings, and the closing report.
//!
//! A command is handed a [`Session`], opens the device through it, marks its phases, and says what it made. When the
//! command is over, and with it everything that it had on the device, [`Session::close`] prints the report.

use super::failure::{Failure, Result};
use super::progress::Progress;
use super::quilting::{Quilting, SearchFlag};
use super::report::{print, warn_on_stderr};
use clap::Args;
use impasto::gpu::{Context, ContextOptions, DeviceChoice, DeviceInfo, LogCallback, PassTime, Runner, Uploads};
use impasto::synthesis::quilt::{QuiltStages, SearchPath};
use serde_json::{json, Map, Value};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Pixel comparisons of one submission: about half a second on a slow device.
pub const PART_COMPARISONS: u64 = 400_000_000;

/// Flags of every command.
#[derive(Args, Debug, Clone)]
pub struct Common {
    /// The device: its index, (part of) its name, its UUID or its PCI address, as `impasto devices` lists them
    #[arg(long, global = true, value_name = "INDEX|NAME|UUID|PCI", help_heading = "Common options")]
    pub device: Option<String>,
    /// Turn on the Vulkan validation layers; any message of theirs makes the exit status 1
    #[arg(long, global = true, help_heading = "Common options")]
    pub validate: bool,
    /// Print one JSON document: device, parameters, GPU time of each pass (of the first 4096 in a submission), wall
    /// time of each phase, files, warnings
    #[arg(long, global = true, help_heading = "Common options")]
    pub json: bool,
    /// Print nothing but errors
    #[arg(short, long, global = true, help_heading = "Common options")]
    pub quiet: bool,
}

/// A command at work.
pub struct Session {
    command: &'static str,
    common: Common,
    started: Instant,
    phase_started: Instant,
    phases: Vec<(&'static str, Duration)>,
    device: Option<DeviceInfo>,
    passes: Vec<PassTime>,
    warnings: Vec<String>,
    messages: Arc<Mutex<Vec<String>>>,
    parameters: Map<String, Value>,
    results: Map<String, Value>,
    lines: Vec<String>,
    outputs: Vec<PathBuf>,
    closing: Option<String>,
    document: Option<Value>,
    wrong: Option<String>,
}

/// An open device.
pub struct Device {
    /// The device itself.
    pub context: Context,
    /// Submits to it.
    pub runner: Runner,
    /// Compiled when they are first asked for.
    quilt_stages: Option<Arc<QuiltStages>>,
}

impl Session {
    /// Begins a command: its clock runs from here.
    pub fn new(command: &'static str, common: Common) -> Self {
        let now = Instant::now();
        Session {
            command,
            common,
            started: now,
            phase_started: now,
            phases: Vec::new(),
            device: None,
            passes: Vec::new(),
            warnings: Vec::new(),
            messages: Arc::default(),
            parameters: Map::new(),
            results: Map::new(),
            lines: Vec::new(),
            outputs: Vec::new(),
            closing: None,
            document: None,
            wrong: None,
        }
    }

    /// A session for a command that is run by this one.
    pub fn inner(&self, command: &'static str) -> Self {
        Session { messages: self.messages.clone(), ..Session::new(command, self.common.clone()) }
    }

    /// A session for parts of the work that are not to show any progress of their own.
    pub fn silent(&self) -> Self {
        let mut silent = self.inner(self.command);
        silent.common.quiet = true;
        silent
    }

    /// Takes over what an inner session has to report, but for its parameters, findings and files.
    pub fn adopt(&mut self, inner: Session) {
        self.device = inner.device.or(self.device.take());
        self.warnings.extend(inner.warnings);
        self.add_times(inner.passes);
    }

    /// Opens the device that was asked for.
    pub fn open_device(&mut self) -> Result<Device> {
        let device = Device::asked_for(&self.common, &self.messages)?;
        self.device = Some(device.context.device_info().clone());
        Ok(device)
    }

    /// Opens a device by its index, for a command that opens several. Pipelines of earlier runs are not looked for.
    pub fn open_uncached(&self, index: usize) -> Result<Device> {
        Device::open(DeviceChoice::Index(index), self.common.validate, None, &self.messages)
    }

    /// The device that was asked for, if one was.
    pub fn device_choice(&self) -> Option<DeviceChoice> {
        self.common.device.as_deref().map(|text| {
            let Ok(choice) = text.parse();
            choice
        })
    }

    /// Loads what the command is given while another thread opens the device and, if the command quilts, compiles the
    /// stages of quilting with these flags: each takes about as long as reading a large model. What is wrong with the
    /// input is told first. Ends the phases `load` and `setup`.
    pub fn load_and_open<T>(
        &mut self,
        quilting: Option<&Quilting>,
        load: impl FnOnce(&mut Session) -> Result<T>,
    ) -> Result<(T, Device)> {
        let (common, messages) = (self.common.clone(), self.messages.clone());
        let open = || -> Result<Device> {
            let mut device = Device::asked_for(&common, &messages)?;
            // What runs beside it would disturb a calibration.
            if let Some(quilting) = quilting.filter(|quilting| quilting.search != SearchFlag::Calibrate) {
                device.quilt_stages(quilting.search)?.compile(&quilting.params(false))?;
            }
            Ok(device)
        };
        std::thread::scope(|scope| {
            let opening = scope.spawn(open);
            let loaded = load(self)?;
            self.phase("load");
            let device = opening.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
            self.device = Some(device.context.device_info().clone());
            self.phase("setup");
            Ok((loaded, device))
        })
    }

    /// The stages of quilting; one serves every quilting of the command. The report tells by which path they search.
    pub fn quilt_stages(&mut self, device: &mut Device, search: SearchFlag) -> Result<Arc<QuiltStages>> {
        let stages = device.quilt_stages(search)?;
        self.attach("quilt_search", search_json(search, stages.path()));
        Ok(stages)
    }

    /// Ends a phase of the work: what has passed since the one before is its time.
    pub fn phase(&mut self, name: &'static str) {
        let now = Instant::now();
        let time = now - self.phase_started;
        self.phase_started = now;
        match self.phases.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += time,
            None => self.phases.push((name, time)),
        }
    }

    /// Whether the validation layers were asked for.
    pub fn validates(&self) -> bool {
        self.common.validate
    }

    /// Takes note of the GPU times of all passes run so far.
    pub fn take_times(&mut self, runner: &mut Runner) {
        self.add_times(runner.take_times());
    }

    fn add_times(&mut self, times: Vec<PassTime>) {
        for time in times {
            match self.passes.iter_mut().find(|sum| sum.name == time.name) {
                Some(sum) => {
                    sum.count += time.count;
                    sum.total_ns += time.total_ns;
                }
                None => self.passes.push(time),
            }
        }
    }

    /// Tells the user of something that looks wrong.
    pub fn warn(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.common.quiet {
            warn_on_stderr(&text);
        }
        self.warnings.push(text);
    }

    /// A bar for `steps` steps of work.
    pub fn progress(&self, what: &'static str, steps: usize) -> Progress {
        Progress::new(what, steps, self.common.quiet)
    }

    /// A bar for frames.
    pub fn frames(&self, what: &'static str, frames: usize) -> Progress {
        Progress::frames(what, frames, self.common.quiet)
    }

    /// A parameter for the report.
    pub fn parameter(&mut self, name: &str, value: impl Into<Value>) {
        self.parameters.insert(name.to_owned(), value.into());
    }

    /// A finding for the report: under `name` in JSON, as `line` otherwise.
    pub fn result(&mut self, name: &str, value: impl Into<Value>, line: impl Into<String>) {
        self.results.insert(name.to_owned(), value.into());
        self.lines.push(line.into());
    }

    /// A finding that only the JSON report tells.
    pub fn attach(&mut self, name: &str, value: impl Into<Value>) {
        self.results.insert(name.to_owned(), value.into());
    }

    /// All parameters so far, for a report of the command's own.
    pub fn parameters_json(&self) -> Value {
        Value::Object(self.parameters.clone())
    }

    /// The device in use, for the same.
    pub fn device_json(&self) -> Value {
        self.device.as_ref().map_or(Value::Null, device_json)
    }

    /// A line that ends the report where it is not JSON.
    pub fn closing_line(&mut self, line: String) {
        self.closing = Some(line);
    }

    /// What `--json` prints in place of the report.
    pub fn replace_document(&mut self, document: Value) {
        self.document = Some(document);
    }

    /// What is wrong with what was found: the command fails with it, but its report is printed all the same.
    pub fn found_wrong(&mut self, text: String) {
        self.wrong = Some(text);
    }

    /// Files that were written.
    pub fn wrote(&mut self, paths: Vec<PathBuf>) {
        self.outputs.extend(paths);
    }

    /// How long the command has run.
    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// Prints the report of a command that went well, and in any case what the validation layers said. To be called
    /// when nothing of the command is left on the device, for they may speak up to the end.
    ///
    /// # Errors
    /// The command's own, validation messages, what was found wrong, or a standard output that cannot be written to.
    pub fn close(mut self, result: Result) -> Result {
        let messages = self.messages.lock().map(|messages| messages.clone()).unwrap_or_default();
        for message in &messages {
            warn_on_stderr(&format!("validation: {message}"));
        }
        result?;
        if self.common.json {
            let document = self.document.take().unwrap_or_else(|| self.document(&messages));
            print(&format!("{document:#}\n"))?;
        } else if !self.common.quiet {
            print(&self.summary())?;
        }
        match (messages.len(), self.wrong) {
            (0, None) => Ok(()),
            (0, Some(wrong)) => Err(Failure::new(wrong)),
            (count, _) => Err(Failure::new(format!("{count} message(s) of the validation layers"))),
        }
    }

    fn document(&self, messages: &[String]) -> Value {
        let passes: Vec<Value> = self
            .passes
            .iter()
            .map(|pass| json!({ "name": pass.name, "count": pass.count, "gpu_ms": pass.total_ns as f64 / 1e6 }))
            .collect();
        let mut wall: Map<String, Value> =
            self.phases.iter().map(|(name, time)| ((*name).to_owned(), milliseconds(*time))).collect();
        wall.insert("total".to_owned(), milliseconds(self.elapsed()));
        let mut document = json!({
            "tool": "impasto",
            "version": env!("CARGO_PKG_VERSION"),
            "command": self.command,
            "device": self.device.as_ref().map(device_json),
            "parameters": self.parameters,
            "passes": passes,
            "wall_ms": wall,
            "outputs": self.outputs.iter().map(|path| path.display().to_string()).collect::<Vec<_>>(),
            "warnings": self.warnings,
            "validation_messages": messages,
        });
        if let Some(document) = document.as_object_mut() {
            document.extend(self.results.clone());
        }
        document
    }

    fn summary(&self) -> String {
        let mut text = String::new();
        for line in &self.lines {
            text.push_str(&format!("{line}\n"));
        }
        // A command with a last word of its own has a page to show in place of a long list.
        let listed = if self.closing.is_none() { &self.outputs[..] } else { &[] };
        for path in listed {
            text.push_str(&format!("wrote {}\n", path.display()));
        }
        let seconds = self.elapsed().as_secs_f64();
        match &self.device {
            Some(device) => text.push_str(&format!("{seconds:.2} s on {}\n", device.name)),
            None if self.outputs.is_empty() => {}
            None => text.push_str(&format!("{seconds:.2} s\n")),
        }
        if let Some(line) = &self.closing {
            text.push_str(&format!("{line}\n"));
        }
        text
    }
}

impl Device {
    fn asked_for(common: &Common, messages: &Arc<Mutex<Vec<String>>>) -> Result<Self> {
        let Ok(choice) = common.device.as_deref().map_or(Ok(DeviceChoice::Best), str::parse);
        Self::open(choice, common.validate, cache_dir(), messages).map_err(|failure| match &common.device {
            Some(_) => Failure::new(format!("--device: {}", failure.0)),
            None => failure,
        })
    }

    fn open(
        device: DeviceChoice,
        validation: bool,
        pipeline_cache_dir: Option<PathBuf>,
        messages: &Arc<Mutex<Vec<String>>>,
    ) -> Result<Self> {
        let sink = messages.clone();
        let log: LogCallback = Arc::new(move |_, message| match sink.lock() {
            Ok(mut messages) if validation => messages.push(message.to_owned()),
            _ => warn_on_stderr(message),
        });
        let options = ContextOptions { device, validation, log: Some(log), pipeline_cache_dir, memory_budget: None };
        let context = Context::new(&options)?;
        let runner = Runner::new(&context)?;
        Ok(Device { context, runner, quilt_stages: None })
    }

    fn quilt_stages(&mut self, search: SearchFlag) -> Result<Arc<QuiltStages>> {
        if let Some(stages) = &self.quilt_stages {
            return Ok(stages.clone());
        }
        Ok(self.quilt_stages.insert(search.stages(&self.context)?).clone())
    }

    /// Checks a picture's size against the device's limit.
    pub fn check_size(&self, size: super::values::Size) -> Result {
        let most = self.context.caps().max_image_2d_px;
        if size.width.max(size.height) > most {
            let name = &self.context.device_info().name;
            return Err(Failure::new(format!("--size is {size}, but {name} takes at most {most} pixels a side")));
        }
        Ok(())
    }

    /// Copies what is staged to the device.
    pub fn upload(&mut self, uploads: &mut Uploads) -> Result {
        self.runner.run(|recorder| {
            uploads.record(recorder);
            Ok(())
        })?;
        Ok(())
    }
}

/// A device as the report tells of it.
pub fn device_json(device: &DeviceInfo) -> Value {
    json!({
        "index": device.index,
        "name": device.name,
        "kind": device.kind.to_string(),
        "uuid": device.uuid.to_string(),
        "api_version": device.api_version_text(),
        "driver_version": device.driver_version,
        "driver_name": device.driver_name,
        "driver_info": device.driver_info,
        "pci": device.pci.map(|address| address.to_string()),
        "vendor_id": device.vendor_id,
        "device_id": device.device_id,
    })
}

/// How positions were searched through, as the report tells of it; searches that are never pruned are so from no number
/// of comparisons on.
fn search_json(search: SearchFlag, path: SearchPath) -> Value {
    json!({
        "chosen": format!("{search:?}").to_lowercase(),
        "parts": path.parts,
        "prune_from": (path.prune_from != SearchPath::NEVER).then_some(path.prune_from),
    })
}

fn milliseconds(time: Duration) -> Value {
    // Microseconds are enough, and read better than 17 digits.
    json!((time.as_secs_f64() * 1e6).round() / 1e3)
}

/// Where the program keeps compiled pipelines, after the XDG base directory specification; relative paths do not count.
fn cache_dir() -> Option<PathBuf> {
    let absolute = |name| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let base = absolute("XDG_CACHE_HOME").or_else(|| absolute("HOME").map(|home| home.join(".cache")))?;
    Some(base.join("impasto"))
}
