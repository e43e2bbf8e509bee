//! The lease of a job whose client is there.

use super::{Arc, Service, Settings, User};
use crate::{
    error::Code,
    lease::tests::{engine, run, session},
    server::Panel,
};
use std::net::{IpAddr, Ipv4Addr};
use teleop::LIVENESS_MS;

#[test]
fn the_lease_of_a_job_is_its_clients_while_that_client_is_there() {
    let panel = Arc::new(Panel::that(engine(), "service"));
    let mut service = Service::new(&panel, false, Settings::default());
    let id = service.server.connect(IpAddr::V4(Ipv4Addr::LOCALHOST), 0).unwrap();
    service.server.receive(id, b"INGRESAR ana:x\nENVIAR_NUEVO G0 X1\nEJECUTAR\n", 0);
    service.server.signed_in(id, Ok(true), 0);
    let ana = panel.clients.enter_without_page(&session("ana"));
    service.owner = Some(User { session: session("ana"), client: ana });
    let eva = panel.clients.enter(&session("eva"));
    run(async {
        let take = |client, force| {
            let panel = panel.clone();
            async move {
                let of = session("");
                panel.clients.take(&panel.engine, client, &of, force).await.map_err(|e| e.code)
            }
        };
        take(ana, false).await.unwrap();
        // The start is checked, then the job runs, and its client asks for the progress.
        for (now, begins) in [(30_000, true), (39_000, false), (48_000, false)] {
            if begins {
                service.server.started(Ok(()), now);
            } else {
                service.server.receive(id, b"AVANCE\n", now);
            }
            service.now = now + LIVENESS_MS;
            panel.clients.silence();
            service.show();
            assert_eq!(take(eva, true).await, Err(Code::Conflict), "{now}");
        }
        service.now += 1;
        panel.clients.silence();
        service.show();
        assert_eq!(take(eva, true).await, Ok(()));
    });
    std::fs::remove_dir_all(panel.place.folder()).unwrap();
}
