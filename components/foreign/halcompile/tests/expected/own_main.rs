//! `own_main`, from its .comp file: the declaration is whole, the C text is to be translated.
#![forbid(unsafe_code)]

// The C text beside the functions:
//
//     static int first = 3;
//     RTAPI_MP_INT(first, "What the first one adds.");
//     static char *label[2] = {0, 0};
//     RTAPI_MP_ARRAY_STRING(label, 2, "What the two are called.");
//
//     int rtapi_app_main(void) {
//         int rc, i;
//         comp_id = hal_init("own_main");
//         if (comp_id < 0) return comp_id;
//         for (i = 0; i < 2; i++) {
//             char name[HAL_NAME_LEN + 1];
//             rtapi_snprintf(name, sizeof(name), "own.%s", label[i] ? label[i] : i ? "second" : "first");
//             rc = export(name, first + i);
//             if (rc != 0) {
//                 hal_exit(comp_id);
//                 return rc;
//             }
//         }
//         hal_ready(comp_id);
//         return 0;
//     }
//
//     void rtapi_app_exit(void) { hal_exit(comp_id); }
//
//     EXTRA_SETUP() { (void)prefix; add = (int)extra_arg; return 0; }

use hal_component::{Builder, Component, Error, In, Out, Period, Touch, Update};

/// The C text has its own beginning and end.
struct OwnMain;

impl Component for OwnMain {
    const NAME: &'static str = "own_main";
    const DOC: &'static str = "The C text has its own beginning and end.";

    fn create(b: &mut Builder<'_>) -> Result<(), Error> {
        // The C file had its own rtapi_app_main: set the flag ONCE, and declare here what
        // it exported, under full names.
        // EXTRA_SETUP ran here, before the pins were made.
        let in_: In<i32> = b.item("in", "Pin `in`; the C file does not say what it means.", 0)?;
        let out: Out<i32> = b.item("out", "Pin `out`; the C file does not say what it means.", 0)?;
        b.function("", "The C text has its own beginning and end.", OwnMainFunction { in_, out, add: 0 })?;
        Ok(())
    }
}

/// The C text has its own beginning and end.
#[expect(dead_code, reason = "the C text is still to be translated")]
#[derive(Touch)]
struct OwnMainFunction {
    in_: In<i32>,
    out: Out<i32>,
    #[state]
    add: i32,
}

impl Update for OwnMainFunction {
    fn update(&mut self, _period: Period) {
        // To be translated:
        //
        //      out = in + add;
    }
}

hal_component::export!(OwnMain);
