//! Pages of HTML.

use crate::book::{Book, Chapter};
use pulldown_cmark::{CowStr, Event, Options, Parser, Tag, TagEnd, html};
use std::{fs, io::Result};

/// Returns the files of the manual: a page for each chapter, pictures, colours, and the search with its index.
pub(crate) fn pages(book: &Book) -> Result<Vec<(String, Vec<u8>)>> {
    let mut files = book.pictures.clone();
    for name in ["manual.css", "search.js"] {
        files.push((name.to_owned(), fs::read(format!("page/{name}"))?));
    }
    let mut index = "const MANUAL = [\n".to_owned();
    for (n, chapter) in book.chapters.iter().enumerate() {
        let (body, sections) = body(&chapter.text);
        for (id, title, words) in sections {
            let at = format!("{}#{id}", html_name(&chapter.file));
            index += &format!("[{at:?}, {:?}, {title:?}, {words:?}],\n", chapter.title);
        }
        let page = framed(book, n, chapter, &body);
        if n == 0 {
            files.push(("index.html".to_owned(), page.clone().into_bytes()));
        }
        files.push((html_name(&chapter.file), page.into_bytes()));
    }
    files.push(("words.js".to_owned(), (index + "];\n").into_bytes()));
    Ok(files)
}

fn html_name(file: &str) -> String {
    format!("{}.html", file.trim_end_matches(".md"))
}

fn framed(book: &Book, n: usize, chapter: &Chapter, body: &str) -> String {
    let mut list = String::new();
    let mut part = "";
    for (other, c) in book.chapters.iter().enumerate() {
        if c.part != part {
            part = &c.part;
            list += &format!("<p>{}</p>\n", escaped(part));
        }
        let here = if other == n { " aria-current=\"page\"" } else { "" };
        list += &format!("<a href=\"{}\"{here}>{}</a>\n", html_name(&c.file), escaped(&c.title));
    }
    let turn = |n: Option<usize>, sign: &str| {
        n.and_then(|n| book.chapters.get(n)).map_or_else(String::new, |c| {
            format!("<a href=\"{}\">{sign} {}</a>", html_name(&c.file), escaped(&c.title))
        })
    };
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>{} · {}</title>\
         <link rel=\"stylesheet\" href=\"manual.css\"><script src=\"words.js\" defer></script><script src=\"search.js\" defer></script></head>\n\
         <body><nav><a class=\"title\" href=\"index.html\">{}</a><input type=\"search\" id=\"search\" placeholder=\"Search\" aria-label=\"Search\">\
         <div id=\"found\"></div>\n{list}</nav>\n<main>{body}<footer>{}<span></span>{}</footer></main></body></html>\n",
        escaped(&chapter.title),
        escaped(&book.title),
        escaped(&book.title),
        turn(n.checked_sub(1), "←"),
        turn(Some(n + 1), "→"),
    )
}

/// Section: its id, its heading and its words.
type Section = (String, String, String);

fn body(text: &str) -> (String, Vec<Section>) {
    let options = Options::ENABLE_TABLES | Options::ENABLE_STRIKETHROUGH;
    let mut sections: Vec<Section> = Vec::new();
    let mut events = Vec::new();
    let mut heading: Option<(usize, String)> = None;
    for event in Parser::new_ext(text, options) {
        let event = match event {
            Event::Start(Tag::Heading { .. }) => {
                heading = Some((events.len(), String::new()));
                event
            }
            Event::End(TagEnd::Heading(level)) => {
                if let Some((at, title)) = heading.take() {
                    let mut id = id_of(&title);
                    let same = sections.iter().filter(|s| s.0 == id).count();
                    if same > 0 {
                        id = format!("{id}-{same}");
                    }
                    let start = Tag::Heading {
                        level,
                        id: Some(CowStr::from(id.clone())),
                        classes: Vec::new(),
                        attrs: Vec::new(),
                    };
                    if let Some(place) = events.get_mut(at) {
                        *place = Event::Start(start);
                    }
                    sections.push((id, title, String::new()));
                }
                event
            }
            Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                let dest_url = page_link(dest_url);
                Event::Start(Tag::Link { link_type, dest_url, title, id })
            }
            // The words behind the language are for the test of the manual.
            Event::Start(Tag::CodeBlock(pulldown_cmark::CodeBlockKind::Fenced(info))) => {
                let language = info.split(',').next().unwrap_or_default().to_owned();
                let kind = pulldown_cmark::CodeBlockKind::Fenced(CowStr::from(language));
                Event::Start(Tag::CodeBlock(kind))
            }
            // Comments are for people who edit the pages.
            Event::Html(_) | Event::InlineHtml(_) => continue,
            Event::Text(ref words) | Event::Code(ref words) => {
                if let Some((_, title)) = &mut heading {
                    title.push_str(words);
                } else if let Some((_, _, all)) = sections.last_mut() {
                    all.push_str(words);
                    all.push(' ');
                }
                event
            }
            other => other,
        };
        events.push(event);
    }
    let mut out = String::new();
    html::push_html(&mut out, events.into_iter());
    (out, sections)
}

/// Returns the id of a heading, as mdBook makes it.
fn id_of(title: &str) -> String {
    let kept = title.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c.to_ascii_lowercase() }).collect()
}

/// Returns a link to a chapter as a link to its page.
fn page_link(link: CowStr<'_>) -> CowStr<'_> {
    if link.contains("://") {
        return link;
    }
    let (file, place) = link.split_once('#').map_or((&*link, None), |(f, p)| (f, Some(p)));
    let file = if file.ends_with(".md") { html_name(file) } else { file.to_owned() };
    CowStr::from(file + &place.map(|p| format!("#{p}")).unwrap_or_default())
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
