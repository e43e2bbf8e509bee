//! Functions `hal_pin_…` and `hal_param_…`: C pins are ordinary pins.

use crate::{
    loading::{Loading, loading},
    module::Module,
    second_copy::Made,
};
use core::ffi::{CStr, c_char, c_double, c_int, c_long, c_ulong, c_void};
use hal_component::abi::{ItemSpec, Status, Str, dir, edit, level, size, ty};
use std::sync::atomic::Ordering::Relaxed;

/// Reads a C string of the component.
pub(crate) fn text<'t>(p: *const c_char) -> Option<&'t str> {
    if p.is_null() {
        return None;
    }
    // SAFETY: the component passes a C string, alive across its call.
    unsafe { CStr::from_ptr(p) }.to_str().ok()
}

/// Logs and keeps the reason of a refusal, and returns its error number.
pub(crate) fn refuse(loading: Option<&Loading>, status: c_int, why: &str) -> c_int {
    let said = |m: &Module| m.say(level::ERR, &format!("HAL: ERROR: {why}"));
    match (loading, crate::running::module()) {
        (Some(l), _) => {
            l.refusals.borrow_mut().push(why.to_owned());
            said(&l.module);
        }
        (None, Some(m)) => said(m),
        (None, None) => crate::message::write_error(&["HAL: ERROR: ", why, "\n"]),
    }
    status
}

struct New {
    name: *const c_char,
    ty: u8,
    dir: c_int,
    component: c_int,
}

fn item(new: &New, initial: u64, storage: *mut c_void, place: *mut *mut c_void) -> c_int {
    let Some(l) = loading() else {
        let why = "pins and parameters are made while the component is loaded";
        return refuse(None, Status::EINVAL.0, why);
    };
    let Some(name) = text(new.name) else {
        return refuse(Some(l), Status::EINVAL.0, "a name is not UTF-8");
    };
    if new.component == l.module.id() && l.module.ready.load(Relaxed) {
        let why = format!("'{name}': called after hal_ready");
        return refuse(Some(l), Status::EINVAL.0, &why);
    }
    let Ok(owner) = u32::try_from(new.component) else {
        let why = format!("'{name}': there is no component {}", new.component);
        return refuse(Some(l), Status::EINVAL.0, &why);
    };
    let full = format!("{}{name}", l.module.prefix);
    let spec = ItemSpec {
        size: size::<ItemSpec>(),
        flags: 0,
        name: Str::borrow(&full),
        doc: Str::borrow(l.module.docs.item(&full)),
        old_name: Str::NONE,
        initial,
        storage,
        ty: new.ty,
        dir: u8::try_from(new.dir).unwrap_or(0),
    };
    let make = l.file.item;
    // SAFETY: the engine's function; the record lives across the call.
    let made = make.map(|f| unsafe { f(l.host.ctx, &raw const spec, owner, place) });
    let status = made.unwrap_or(Status::EINVAL);
    l.items.borrow_mut().push(Made::new(&full, &spec, place, status));
    status.0
}

/// Makes a pin whose address is stored at `place`.
fn pin(new: &New, bits: u64, place: *mut *mut c_void) -> c_int {
    let l = loading();
    if ![dir::IN, dir::OUT, dir::IO].map(c_int::from).contains(&new.dir) {
        return refuse(l, Status::EINVAL.0, "a pin is neither HAL_IN, HAL_OUT nor HAL_IO");
    }
    let mine = l.is_none_or(|l| l.module.memory.holds(place.addr(), size_of::<*mut c_void>()));
    // A kinematics module makes pins while another module is loaded, so any aligned pointer is accepted for those.
    let own = l.is_some_and(|l| l.module.id() == new.component);
    if place.is_null() || !place.is_aligned() || (own && !mine) {
        let why = format!(
            "pin '{}': its pointer is not in memory of hal_malloc",
            text(new.name).unwrap_or("?")
        );
        return refuse(l, Status::EINVAL.0, &why);
    }
    let made = item(new, bits, core::ptr::null_mut(), place);
    if let Some(l) = l.filter(|_| made == 0 && new.ty == ty::PORT) {
        l.ports.borrow_mut().push(place.expose_provenance());
    }
    made
}

/// Makes a parameter whose value is at `place`.
fn param(new: &New, place: *mut c_void) -> c_int {
    let l = loading();
    if ![dir::RO, dir::RW].map(c_int::from).contains(&new.dir) {
        return refuse(l, Status::EINVAL.0, "a parameter is neither HAL_RO nor HAL_RW");
    }
    let width = match new.ty {
        ty::BIT => 1,
        ty::S32 | ty::U32 => 4,
        _ => 8,
    };
    if place.is_null() || !place.addr().is_multiple_of(width) {
        let why = format!("parameter '{}': it has no place", text(new.name).unwrap_or("?"));
        return refuse(l, Status::EINVAL.0, &why);
    }
    item(new, 0, place, core::ptr::null_mut())
}

macro_rules! classic {
    ($($ty:ident $pin:ident $param:ident)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $pin(
            name: *const c_char,
            dir: c_int,
            place: *mut *mut c_void,
            component: c_int,
        ) -> c_int {
            pin(&New { name, ty: ty::$ty, dir, component }, 0, place)
        }

        #[unsafe(no_mangle)]
        extern "C" fn $param(
            name: *const c_char,
            dir: c_int,
            place: *mut c_void,
            component: c_int,
        ) -> c_int {
            param(&New { name, ty: ty::$ty, dir, component }, place)
        }
    )*};
}

classic! {
    BIT hal_pin_bit_new hal_param_bit_new
    FLOAT hal_pin_float_new hal_param_float_new
    S32 hal_pin_s32_new hal_param_s32_new
    U32 hal_pin_u32_new hal_param_u32_new
    S64 hal_pin_s64_new hal_param_s64_new
    U64 hal_pin_u64_new hal_param_u64_new
}

#[unsafe(no_mangle)]
extern "C" fn hal_pin_port_new(
    name: *const c_char,
    dir: c_int,
    place: *mut *mut c_void,
    component: c_int,
) -> c_int {
    pin(&New { name, ty: ty::PORT, dir, component }, 0, place)
}

#[unsafe(no_mangle)]
extern "C" fn hal_pin_new(
    name: *const c_char,
    ty: c_int,
    dir: c_int,
    place: *mut *mut c_void,
    component: c_int,
) -> c_int {
    pin(&New { name, ty: code(ty), dir, component }, 0, place)
}

#[unsafe(no_mangle)]
extern "C" fn hal_param_new(
    name: *const c_char,
    ty: c_int,
    dir: c_int,
    place: *mut c_void,
    component: c_int,
) -> c_int {
    param(&New { name, ty: code(ty), dir, component }, place)
}

fn code(ty: c_int) -> u8 {
    u8::try_from(ty).unwrap_or(0)
}

/// Makes a pin with an initial value, for the newer interface.
#[unsafe(no_mangle)]
extern "C" fn ferrule_new_pin(
    component: c_int,
    ty: c_int,
    dir: c_int,
    place: *mut *mut c_void,
    bits: u64,
    name: *const c_char,
) -> c_int {
    pin(&New { name, ty: code(ty), dir, component }, bits, place)
}

/// Makes a parameter for the newer interface; its 64-bit storage is allocated here.
#[unsafe(no_mangle)]
extern "C" fn ferrule_new_param(
    component: c_int,
    ty: c_int,
    dir: c_int,
    place: *mut *mut c_void,
    bits: u64,
    name: *const c_char,
) -> c_int {
    let made = fake(place, bits);
    if made != 0 {
        return made;
    }
    // SAFETY: `fake` has checked and set it.
    let at = unsafe { place.read() };
    param(&New { name, ty: code(ty), dir, component }, at)
}

fn fake(place: *mut *mut c_void, bits: u64) -> c_int {
    let l = loading();
    let inside = |l: &Loading| l.module.memory.holds(place.addr(), size_of::<*mut c_void>());
    let Some(l) = l.filter(|l| place.is_aligned() && inside(l)) else {
        return refuse(l, Status::EINVAL.0, "a handle is not in memory of hal_malloc");
    };
    let Some(at) = l.module.take(8) else { return Status::ENOMEM.0 };
    // SAFETY: a block of 8 bytes, aligned.
    unsafe { at.cast::<u64>().write(bits) };
    // SAFETY: in the component's own memory, aligned.
    unsafe { place.write(at.cast()) };
    0
}

#[unsafe(no_mangle)]
extern "C" fn hal_param_new_fake(_component: c_int, place: *mut *mut c_void) -> c_int {
    fake(place, 0)
}

/// Edits the graph, where a component may do so; names of its own items begin with its prefix.
pub(crate) fn change(what: u32, a: *const c_char, b: *const c_char, number: i64) -> c_int {
    let Some(l) = loading() else {
        return refuse(None, Status::EINVAL.0, "the graph is changed while a component is loaded");
    };
    let named = |own: bool, name: *const c_char| {
        let name = text(name).unwrap_or_default();
        if own && !name.is_empty() { format!("{}{name}", l.module.prefix) } else { name.to_owned() }
    };
    let first = !matches!(what, edit::NEW_SIGNAL | edit::DELETE_SIGNAL);
    let second = matches!(what, edit::ADD | edit::ADD_INIT | edit::REMOVE);
    let (a, b) = (named(first, a), named(second, b));
    // SAFETY: the engine's function; the texts live across the call.
    let done = l
        .file
        .edit
        .map(|f| unsafe { f(l.host.ctx, what, Str::borrow(&a), Str::borrow(&b), number) });
    done.unwrap_or(Status::EINVAL).0
}

#[unsafe(no_mangle)]
extern "C" fn hal_pin_alias(name: *const c_char, alias: *const c_char) -> c_int {
    change(edit::ALIAS_PIN, name, alias, 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_param_alias(name: *const c_char, alias: *const c_char) -> c_int {
    change(edit::ALIAS_PARAM, name, alias, 0)
}

fn set(name: *const c_char, value: &str) -> c_int {
    let value = std::ffi::CString::new(value).unwrap_or_default();
    change(edit::SET, name, value.as_ptr(), 0)
}

#[unsafe(no_mangle)]
extern "C" fn hal_param_bit_set(name: *const c_char, value: c_int) -> c_int {
    set(name, if value != 0 { "1" } else { "0" })
}

#[unsafe(no_mangle)]
extern "C" fn hal_param_float_set(name: *const c_char, value: c_double) -> c_int {
    set(name, &format!("{value:e}"))
}

#[unsafe(no_mangle)]
extern "C" fn hal_param_s32_set(name: *const c_char, value: c_long) -> c_int {
    set(name, &value.to_string())
}

#[unsafe(no_mangle)]
extern "C" fn hal_param_u32_set(name: *const c_char, value: c_ulong) -> c_int {
    set(name, &value.to_string())
}

#[unsafe(no_mangle)]
extern "C" fn hal_param_set(name: *const c_char, ty: c_int, value: *mut c_void) -> c_int {
    if value.is_null() {
        return Status::EINVAL.0;
    }
    let text = match code(ty) {
        ty::BIT => u8::from(at::<u8>(value) != 0).to_string(),
        ty::S32 => at::<i32>(value).to_string(),
        ty::U32 => at::<u32>(value).to_string(),
        ty::S64 => at::<i64>(value).to_string(),
        ty::U64 => at::<u64>(value).to_string(),
        _ => format!("{:e}", at::<f64>(value)),
    };
    set(name, &text)
}

fn at<T: Copy>(value: *const c_void) -> T {
    // SAFETY: the component passes a value of this type.
    unsafe { value.cast::<T>().read_unaligned() }
}
