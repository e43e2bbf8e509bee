//! Layout of every record of the ABI. A change of a line breaks libraries that are already built. A
//! minor version may append fields at the end; any other change needs a new major version.

use core::mem::offset_of;
use std::fmt::Write;

macro_rules! layout {
    ($out:ident, $($t:ty { $($field:ident)* })*) => {$(
        write!($out, "{} {}/{}", stringify!($t), size_of::<$t>(), align_of::<$t>())?;
        $(write!($out, " {}@{}", stringify!($field), offset_of!($t, $field))?;)*
        writeln!($out)?;
    )*};
}

fn table() -> Result<String, std::fmt::Error> {
    use hal_abi::{
        ActionSpec, ArgSpec, ArgValue, CallHost, Cell, CommandSpec, ComponentType, FieldSpec,
        ForeignFile, ForeignLoader, FunctSpec, Homing, HomingJoint, HomingSettings, Host,
        Interlock, IoCommand, IoControl, IoOutcome, IoStatus, ItemSpec, Kinematics, Library, List,
        Motion, MotionAnswer, MotionCommand, Operator, OperatorCommand, OperatorView, Page,
        PortQueue, Ring, ServiceRef, ServiceSpec, Slot, SnapshotRef, SnapshotSpec, Status, Str,
        StreamRef, StreamSpec, TaskSpec, ThreadSpec, Ticket, Use, WorkerSpec,
    };
    let mut out = String::new();
    layout! { out,
        Cell {}
        Slot {}
        Str {}
        List<ArgSpec> {}
        Status {}
        Ticket {}
        PortQueue {}
        Library { size abi_major abi_minor panic components loaders }
        ForeignLoader { size flags symbol kind load }
        ForeignFile { size component instance path name prefix words n_words item rename need edit say level account join describe }
        ComponentType { size flags name doc args items create }
        ArgSpec { size kind most required name doc default low high bounds reserved unit }
        ItemSpec { size flags name doc old_name initial storage ty dir }
        Use { slot token access }
        FunctSpec { size flags name doc run state free uses n_uses }
        TaskSpec { size flags name doc period_ns run state free uses n_uses }
        ThreadSpec { size flags name period_ns }
        StreamSpec { size direction name depth width types }
        CommandSpec { size flags name doc args run state free }
        ActionSpec { size flags run state free }
        ServiceSpec { size version name table state free uses n_uses }
        Kinematics { size joints kind joint_of ctx forward inverse types solutions switch worker_ctx }
        Homing { size flags ctx name open configure put take call state }
        HomingSettings { size flags sequence volatile_home offset home final_velocity search_velocity latch_velocity }
        HomingJoint { size flags max_limit min_limit max_jog min_jog max_velocity max_acceleration min_ferror max_ferror backlash pos_cmd vel_cmd acc_cmd backlash_corr backlash_filt backlash_vel motor_pos_cmd motor_pos_fb pos_fb ferror ferror_limit motor_offset target planner_velocity planner_acceleration planner_pos planner_vel }
        Interlock { size flags ctx state }
        IoCommand { size kind tool pocket index changes values }
        IoControl { size flags ctx request result state }
        IoOutcome { id why }
        IoStatus { interlock outputs tool pocket prepared reserved }
        Motion { size flags ctx acquire release claim room push poll status setting epoch }
        Operator { size flags ctx take show }
        OperatorCommand { size kind value len text epoch }
        OperatorView { size mode program optional_stop block_delete reserved tool_diameter zero rotation }
        MotionAnswer { size len id text }
        MotionCommand { size kind source line flags letters index mode speed_kind extent count setting pose center normal reserved speed acceleration tolerance cam_tolerance scale value pitch epoch }
        ArgValue { size given int float text ints texts len }
        StreamRef { ring depth width }
        ServiceRef { table uses n_uses }
        CallHost { size flags ctx message now fail arg reply ticket awaited ask_value take_value gaps hardware failed_hardware }
        Host { size abi_minor flags index personality prefix ctx calls fail arg item funct thread task command open stop stream offer find bind worker snapshot measured }
        WorkerSpec { size flags name doc period_ns run state free uses n_uses items }
        SnapshotSpec { size version name doc fields }
        SnapshotRef { page words }
        Page { magic version words sequence }
        FieldSpec { size count name doc ty }
        Ring { magic depth width types lost }
    }
    Ok(out)
}

#[test]
fn no_record_has_changed() -> Result<(), std::fmt::Error> {
    assert_eq!(hal_abi::ABI_MAJOR, 1, "a new major starts a new table");
    assert_eq!(table()?, include_str!("../layout.txt"));
    Ok(())
}
