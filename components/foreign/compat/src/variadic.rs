//! Functions with variable argument lists: their code is in `shim.c`, but only Rust symbols are exported from the
//! library. Each jumps to its namesake with all arguments in place.

macro_rules! exported {
    ($($name:ident = $code:ident;)*) => {$(
        unsafe extern "C" {
            fn $code();
        }

        #[unsafe(naked)]
        #[unsafe(no_mangle)]
        extern "C" fn $name() {
            #[cfg(target_arch = "x86_64")]
            core::arch::naked_asm!("jmp {}", sym $code);
            #[cfg(target_arch = "aarch64")]
            core::arch::naked_asm!("b {}", sym $code);
        }
    )*};
}

exported! {
    hal_pin_bit_newf = ferrule_c_hal_pin_bit_newf;
    hal_pin_float_newf = ferrule_c_hal_pin_float_newf;
    hal_pin_s32_newf = ferrule_c_hal_pin_s32_newf;
    hal_pin_u32_newf = ferrule_c_hal_pin_u32_newf;
    hal_pin_s64_newf = ferrule_c_hal_pin_s64_newf;
    hal_pin_u64_newf = ferrule_c_hal_pin_u64_newf;
    hal_pin_new_bool = ferrule_c_hal_pin_new_bool;
    hal_pin_new_si32 = ferrule_c_hal_pin_new_si32;
    hal_pin_new_ui32 = ferrule_c_hal_pin_new_ui32;
    hal_pin_new_sint = ferrule_c_hal_pin_new_sint;
    hal_pin_new_uint = ferrule_c_hal_pin_new_uint;
    hal_pin_new_real = ferrule_c_hal_pin_new_real;
    hal_param_bit_newf = ferrule_c_hal_param_bit_newf;
    hal_param_float_newf = ferrule_c_hal_param_float_newf;
    hal_param_s32_newf = ferrule_c_hal_param_s32_newf;
    hal_param_u32_newf = ferrule_c_hal_param_u32_newf;
    hal_param_s64_newf = ferrule_c_hal_param_s64_newf;
    hal_param_u64_newf = ferrule_c_hal_param_u64_newf;
    hal_param_new_bool = ferrule_c_hal_param_new_bool;
    hal_param_new_si32 = ferrule_c_hal_param_new_si32;
    hal_param_new_ui32 = ferrule_c_hal_param_new_ui32;
    hal_param_new_sint = ferrule_c_hal_param_new_sint;
    hal_param_new_uint = ferrule_c_hal_param_new_uint;
    hal_param_new_real = ferrule_c_hal_param_new_real;
    hal_pin_port_newf = ferrule_c_hal_pin_port_newf;
    hal_pin_new_port = ferrule_c_hal_pin_new_port;
    hal_export_functf = ferrule_c_hal_export_functf;
    rtapi_print = ferrule_c_rtapi_print;
    rtapi_print_msg = ferrule_c_rtapi_print_msg;
    rtapi_snprintf = ferrule_c_rtapi_snprintf;
    rtapi_vsnprintf = ferrule_c_rtapi_vsnprintf;
    rtapi_set_msg_handler = ferrule_c_rtapi_set_msg_handler;
    rtapi_get_msg_handler = ferrule_c_rtapi_get_msg_handler;
}
