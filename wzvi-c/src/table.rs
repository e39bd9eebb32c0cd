//! The functions for C. All of the `unsafe` of the library is here: it reads texts and arrays that C hands in.
//! `wzvi.h` is the other side of each function, and its promises are those of the `SAFETY` comments.
//!
//! A task is behind a lock, which its own thread alone takes; the handle that stops it is beside the lock.
//! Nothing unwinds out of a function.

#![allow(unsafe_code, reason = "pointers of C")]

use std::ffi::{CStr, CString, c_char};
use std::mem::MaybeUninit;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, OnceLock, TryLockError};

use wzvi::handle::Handle;

use crate::describe::describe;
use crate::error::TaskError;
use crate::library::{Outcome, System};
use crate::results::Results;
use crate::settings::{Settings, Value};

/// The version of the meaning of the table.
pub const ABI: u32 = 1;

/// The largest number of axes of an array.
pub const AXES: usize = 8;

/// What setters and runs return: done.
pub const DONE: i32 = 0;
/// The run ended early, with results and an error.
pub const PARTIAL: i32 = 1;
/// Nothing was done, and there is an error.
pub const FAILED: i32 = 2;

/// Writes name, numbers and shape of an array, and returns the number of its axes.
pub type ReadArray = extern "C" fn(
    Option<&Task>,
    usize,
    Option<&mut MaybeUninit<*const c_char>>,
    Option<&mut MaybeUninit<*const f64>>,
    Option<&mut [MaybeUninit<usize>; AXES]>,
) -> usize;

/// The table of functions. Later versions append.
#[repr(C)]
pub struct Table {
    /// Its size in bytes.
    pub size: usize,
    /// The version of the meaning of its functions.
    pub abi: u32,
    /// Zero.
    pub reserved: u32,
    /// The systems, for the functions alone.
    contents: &'static Contents,
    /// The description of the library, as JSON.
    pub describe: extern "C" fn(Option<&Table>) -> *const c_char,
    /// Begins a run of a system, of a kind.
    pub begin: unsafe extern "C" fn(Option<&Table>, *const c_char, *const c_char) -> Option<Box<Task>>,
    /// Sets a real number.
    pub set_real: unsafe extern "C" fn(Option<&Task>, *const c_char, f64) -> i32,
    /// Sets an integer.
    pub set_integer: unsafe extern "C" fn(Option<&Task>, *const c_char, i64) -> i32,
    /// Sets a text.
    pub set_text: unsafe extern "C" fn(Option<&Task>, *const c_char, *const c_char) -> i32,
    /// Sets an array of real numbers.
    pub set_reals: unsafe extern "C" fn(Option<&Task>, *const c_char, *const f64, usize, *const usize) -> i32,
    /// Sets an array of integers.
    pub set_integers:
        unsafe extern "C" fn(Option<&Task>, *const c_char, *const i64, usize, *const usize) -> i32,
    /// Runs a task.
    pub run: extern "C" fn(Option<&Task>) -> i32,
    /// Ends a run early, from any thread.
    pub stop: extern "C" fn(Option<&Task>),
    /// How far a run is, from any thread.
    pub progress: extern "C" fn(Option<&Task>, Option<&mut MaybeUninit<u64>>, Option<&mut MaybeUninit<u64>>),
    /// The number of arrays.
    pub results: extern "C" fn(Option<&Task>) -> usize,
    /// Name, numbers and shape of an array; returns the number of its axes.
    pub result: ReadArray,
    /// The names of the observables of an ensemble, one in a line; of other kinds those of time, coordinates
    /// and momenta.
    pub columns: extern "C" fn(Option<&Task>) -> *const c_char,
    /// The error of the last call that failed.
    pub error: extern "C" fn(Option<&Task>) -> *const c_char,
    /// Its kind.
    pub code: extern "C" fn(Option<&Task>) -> *const c_char,
    /// Gives a task back.
    pub end: extern "C" fn(Option<Box<Task>>),
}

impl Table {
    /// The table of these systems.
    pub const fn of(contents: &'static Contents) -> Self {
        Self {
            size: size_of::<Self>(),
            abi: ABI,
            reserved: 0,
            contents,
            describe: describe_all,
            begin,
            set_real,
            set_integer,
            set_text,
            set_reals,
            set_integers,
            run,
            stop,
            progress,
            results,
            result,
            columns,
            error,
            code,
            end,
        }
    }
}

/// The systems of a library, made when they are first asked for.
pub struct Contents {
    make: fn() -> Vec<System>,
    systems: OnceLock<Vec<System>>,
    description: OnceLock<CString>,
}

impl Contents {
    /// The systems that this function makes.
    pub const fn new(make: fn() -> Vec<System>) -> Self {
        Self { make, systems: OnceLock::new(), description: OnceLock::new() }
    }

    /// The systems.
    pub fn systems(&self) -> &[System] {
        self.systems.get_or_init(self.make)
    }
}

/// A run: being set up, running, or done.
pub struct Task {
    /// Stops the run from any thread.
    handle: Handle,
    state: Mutex<TaskState>,
}

struct TaskState {
    system: Result<&'static System, TaskError>,
    kind: String,
    settings: Settings,
    results: Results,
    /// The names of the arrays, and those of the columns, one in a line.
    names: Vec<CString>,
    columns: CString,
    error: CString,
    code: CString,
}

impl TaskState {
    fn fail(&mut self, error: &TaskError) -> i32 {
        (self.error, self.code) = (c_text(&error.text), c_text(error.code));
        FAILED
    }

    /// The outcome of a run, for C.
    fn take(&mut self, Outcome { results, error }: Outcome) -> i32 {
        self.names = results.arrays.iter().map(|array| c_text(&array.name)).collect();
        self.columns = c_text(&results.columns.join("\n"));
        self.results = results;
        match error {
            Some(error) => {
                self.fail(&error);
                PARTIAL
            }
            None => {
                (self.error, self.code) = Default::default();
                DONE
            }
        }
    }
}

/// A text without the zeros inside, which would end it.
fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}

/// Uses the state of a task. `None` for no task, for one that another thread uses, and after a panic.
fn with_state<T>(task: Option<&Task>, use_state: impl FnOnce(&mut TaskState) -> T) -> Option<T> {
    let task = task?;
    let mut state = match task.state.try_lock() {
        Ok(state) => state,
        // What a panic has left is no worse than an error: arrays and texts are replaced as a whole.
        Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
        Err(TryLockError::WouldBlock) => return None,
    };
    catch_unwind(AssertUnwindSafe(|| use_state(&mut state))).ok()
}

extern "C" fn describe_all(table: Option<&Table>) -> *const c_char {
    let Some(table) = table else { return c"{}".as_ptr() };
    let contents = table.contents;
    let text = || contents.description.get_or_init(|| c_text(&describe(contents.systems()))).as_ptr();
    catch_unwind(AssertUnwindSafe(text)).unwrap_or(c"{}".as_ptr())
}

/// Reads a text of C.
///
/// # Safety
/// `text` is null or ends with a zero.
unsafe fn read<'t>(text: *const c_char) -> Result<&'t str, TaskError> {
    if text.is_null() {
        return Err(TaskError::setting("a text is a null pointer"));
    }
    // SAFETY: it is not null, and ends with a zero by the contract of this function.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().map_err(|_| TaskError::setting("a text is not in UTF-8"))
}

/// # Safety
/// `system` and `kind` are null or end with a zero.
unsafe extern "C" fn begin(
    table: Option<&Table>,
    system: *const c_char,
    kind: *const c_char,
) -> Option<Box<Task>> {
    let contents = table?.contents;
    let make = || {
        // SAFETY: by the contract of this function.
        let (named, kind) = unsafe { (read(system), read(kind)) };
        let systems = contents.systems();
        let system = named.and_then(|name| {
            systems.iter().find(|system| system.name == name).ok_or_else(|| {
                let names: Vec<_> = systems.iter().map(|system| system.name).collect();
                TaskError::setting(format!("there is no system `{name}`: there are `{}`", names.join("`, `")))
            })
        });
        let state = TaskState {
            system,
            kind: kind.unwrap_or_default().to_owned(),
            settings: Settings::default(),
            results: Results::default(),
            names: Vec::new(),
            columns: CString::default(),
            error: CString::default(),
            code: CString::default(),
        };
        Box::new(Task { handle: Handle::new(), state: Mutex::new(state) })
    };
    catch_unwind(AssertUnwindSafe(make)).ok()
}

/// Sets a value of a task.
///
/// # Safety
/// `name` is null or ends with a zero.
unsafe fn set(
    task: Option<&Task>,
    name: *const c_char,
    value: impl FnOnce() -> Result<Value, TaskError>,
) -> i32 {
    let set = |state: &mut TaskState| {
        // SAFETY: by the contract of this function.
        let name = unsafe { read(name) };
        match name.and_then(|name| value().map(|value| (name, value))) {
            Ok((name, value)) => {
                state.settings.set(name, value);
                DONE
            }
            Err(error) => state.fail(&error),
        }
    };
    with_state(task, set).unwrap_or(FAILED)
}

/// # Safety
/// `name` is null or ends with a zero.
unsafe extern "C" fn set_real(task: Option<&Task>, name: *const c_char, value: f64) -> i32 {
    // SAFETY: by the contract of this function.
    unsafe { set(task, name, || Ok(Value::Reals(vec![value], Vec::new()))) }
}

/// # Safety
/// `name` is null or ends with a zero.
unsafe extern "C" fn set_integer(task: Option<&Task>, name: *const c_char, value: i64) -> i32 {
    // SAFETY: by the contract of this function.
    unsafe { set(task, name, || Ok(Value::Integers(vec![value], Vec::new()))) }
}

/// # Safety
/// `name` and `value` are null or end with a zero.
unsafe extern "C" fn set_text(task: Option<&Task>, name: *const c_char, value: *const c_char) -> i32 {
    // SAFETY: by the contract of this function.
    unsafe { set(task, name, || Ok(Value::Text(read(value)?.to_owned()))) }
}

/// Copies an array of C, with its shape.
///
/// # Safety
/// `shape` is null or has `axes` lengths; `values` is null or has as many numbers as their product.
unsafe fn copied<T: Clone>(
    values: *const T,
    axes: usize,
    shape: *const usize,
) -> Result<(Vec<T>, Vec<usize>), TaskError> {
    if axes > AXES || shape.is_null() && axes > 0 {
        return Err(TaskError::setting(format!("an array has a shape of at most {AXES} axes")));
    }
    let shape = match axes {
        0 => Vec::new(),
        // SAFETY: it is not null, and has so many lengths by the contract of this function.
        axes => unsafe { std::slice::from_raw_parts(shape, axes) }.to_vec(),
    };
    let count = shape.iter().try_fold(1_usize, |count, &length| count.checked_mul(length));
    let count = count.filter(|count| count.saturating_mul(size_of::<T>()) <= isize::MAX.unsigned_abs());
    let Some(count) = count else {
        return Err(TaskError::setting("an array has more numbers than memory has room for"));
    };
    if count > 0 && values.is_null() {
        return Err(TaskError::setting("an array is a null pointer"));
    }
    let values = match count {
        0 => Vec::new(),
        // SAFETY: it is not null, and has so many numbers by the contract of this function.
        count => unsafe { std::slice::from_raw_parts(values, count) }.to_vec(),
    };
    Ok((values, shape))
}

/// # Safety
/// `name` is null or ends with a zero; `values` and `shape` as for [`copied`].
unsafe extern "C" fn set_reals(
    task: Option<&Task>,
    name: *const c_char,
    values: *const f64,
    axes: usize,
    shape: *const usize,
) -> i32 {
    // SAFETY: by the contract of this function.
    unsafe {
        set(task, name, || copied(values, axes, shape).map(|(values, shape)| Value::Reals(values, shape)))
    }
}

/// # Safety
/// `name` is null or ends with a zero; `values` and `shape` as for [`copied`].
unsafe extern "C" fn set_integers(
    task: Option<&Task>,
    name: *const c_char,
    values: *const i64,
    axes: usize,
    shape: *const usize,
) -> i32 {
    // SAFETY: by the contract of this function.
    unsafe {
        set(task, name, || copied(values, axes, shape).map(|(values, shape)| Value::Integers(values, shape)))
    }
}

extern "C" fn run(task: Option<&Task>) -> i32 {
    let Some(Task { handle, .. }) = task else { return FAILED };
    let run = |state: &mut TaskState| {
        let outcome = match &state.system {
            Ok(system) => system.run(&state.kind, &state.settings, handle),
            Err(error) => Err(error.clone()),
        };
        match outcome {
            Ok(outcome) => state.take(outcome),
            Err(error) => {
                state.take(Outcome { results: Results::default(), error: None });
                state.fail(&error)
            }
        }
    };
    with_state(task, run).unwrap_or(FAILED)
}

extern "C" fn stop(task: Option<&Task>) {
    if let Some(task) = task {
        task.handle.stop();
    }
}

extern "C" fn progress(
    task: Option<&Task>,
    done: Option<&mut MaybeUninit<u64>>,
    all: Option<&mut MaybeUninit<u64>>,
) {
    let progress = task.map(|task| task.handle.progress()).unwrap_or_default();
    if let Some(done) = done {
        done.write(progress.done);
    }
    if let Some(all) = all {
        all.write(progress.all);
    }
}

extern "C" fn results(task: Option<&Task>) -> usize {
    with_state(task, |state| state.results.arrays.len()).unwrap_or(0)
}

extern "C" fn result(
    task: Option<&Task>,
    index: usize,
    name: Option<&mut MaybeUninit<*const c_char>>,
    values: Option<&mut MaybeUninit<*const f64>>,
    shape: Option<&mut [MaybeUninit<usize>; AXES]>,
) -> usize {
    let write = |state: &mut TaskState| {
        let (array, label) = (state.results.arrays.get(index)?, state.names.get(index)?);
        if let Some(name) = name {
            name.write(label.as_ptr());
        }
        if let Some(values) = values {
            values.write(array.values.as_ptr());
        }
        for (room, length) in shape.into_iter().flatten().zip(&array.shape) {
            room.write(*length);
        }
        Some(array.shape.len())
    };
    with_state(task, write).flatten().unwrap_or(0)
}

extern "C" fn columns(task: Option<&Task>) -> *const c_char {
    with_state(task, |state| state.columns.as_ptr()).unwrap_or(c"".as_ptr())
}

extern "C" fn error(task: Option<&Task>) -> *const c_char {
    let of_none = match task {
        None => c"there is no task: the pointer is null",
        Some(_) => c"the task is in use by another thread",
    };
    with_state(task, |state| state.error.as_ptr()).unwrap_or(of_none.as_ptr())
}

extern "C" fn code(task: Option<&Task>) -> *const c_char {
    with_state(task, |state| state.code.as_ptr()).unwrap_or(c"task".as_ptr())
}

extern "C" fn end(task: Option<Box<Task>>) {
    // A panic while memory is given back has nobody to tell.
    let _ = catch_unwind(AssertUnwindSafe(|| drop(task)));
}
