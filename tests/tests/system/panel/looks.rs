//! Looks of the page: languages, themes, screens, and the findings of an automatic check of accessibility.

use super::fixture::Fixture;
use hal_tests::{
    browser::{Browser, DESKTOP, PHONE},
    programs::root,
    tools::Tool,
};
use serde_json::{Value, json};
use std::fs;

#[test]
fn each_language_theme_and_screen_has_all_cards_and_no_error() {
    for (screen, width) in [(DESKTOP, "desktop"), (PHONE, "phone")] {
        let Some(fixture) = Fixture::start(screen) else { return };
        let b = &fixture.browser;
        for language in ["en", "es"] {
            for theme in ["dark", "light"] {
                b.run(&format!(
                    "localStorage.setItem('ferrule-panel', JSON.stringify({{ language: '{language}', theme: '{theme}' }})); location.reload()"
                ));
                b.until(&format!("document.documentElement.lang === '{language}' && document.querySelector('#machine-state')?.textContent"));
                let name = format!("{width}-{language}-{theme}");
                assert_eq!(
                    b.run("return document.querySelectorAll('main .card').length"),
                    13,
                    "{name}"
                );
                assert_eq!(b.run("return document.documentElement.dataset.theme"), theme, "{name}");
                let too_wide = "return document.documentElement.scrollWidth - document.documentElement.clientWidth";
                assert_eq!(b.run(too_wide), 0, "{name}: the page is wider than the screen");
                fixture.picture(&name);
                b.run("document.querySelector('[data-page=integrate]').click()");
                b.until("document.querySelectorAll('#tree .names li').length > 10");
                fixture.picture(&format!("{name}-integrate"));
                b.run("document.querySelector('[data-page=operate]').click()");
            }
        }
        assert_eq!(b.errors(), Vec::<String>::new(), "{width}");
    }
}

/// axe-core, a checker of accessibility, where npm has put it.
const AXE: Tool = Tool {
    name: "axe",
    what: "axe-core",
    remedy: "npm install --no-save --prefix components/remote/panel axe-core",
};

/// Gives the page the checker, and returns what it finds serious or critical.
fn serious(b: &Browser, axe: &str) -> Value {
    b.run(axe);
    b.run("window.found = null; axe.run().then((r) => { window.found = r.violations.filter((v) => ['serious', 'critical'].includes(v.impact)).map((v) => `${v.id}: ${v.nodes.map((n) => n.html.slice(0, 150)).join(' | ')}`); })");
    b.until("window.found");
    b.run("return window.found")
}

#[test]
fn axe_finds_nothing_serious() {
    let script = root().join("components/remote/panel/node_modules/axe-core/axe.min.js");
    let Some(axe) = AXE.or_skip(fs::read_to_string(script).ok()) else { return };
    for screen in [DESKTOP, PHONE] {
        let Some(fixture) = Fixture::start(screen) else { return };
        let b = &fixture.browser;
        for theme in ["dark", "light"] {
            for page in ["operate", "integrate"] {
                b.run(&format!("localStorage.setItem('ferrule-panel', JSON.stringify({{ theme: '{theme}', page: '{page}', watch: ['remote.pulse'] }})); location.reload()"));
                b.until(&format!(
                    "document.documentElement.dataset.theme === '{theme}' && document.body.dataset.page === '{page}' && document.querySelectorAll('main .card').length > 5"
                ));
                if page == "integrate" {
                    b.until("document.querySelectorAll('#tree .names li').length > 10");
                    b.run("document.querySelector('#graph-pattern').value = 'xpos-*'; document.querySelector('#graph').scrollIntoView()");
                    b.until("document.querySelector('#graph svg')");
                }
                assert_eq!(serious(b, &axe), json!([]), "{page}, {theme}, {screen:?}");
            }
        }
        // Without a session there is the form that opens one.
        b.run("sessionStorage.clear(); location.reload()");
        b.until("document.querySelector('.sign-in')");
        for theme in ["dark", "light"] {
            b.run(&format!("document.documentElement.dataset.theme = '{theme}'"));
            assert_eq!(serious(b, &axe), json!([]), "sign-in, {theme}, {screen:?}");
        }
    }
}
