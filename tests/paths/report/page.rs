//! The page: parsed, and opened in a browser where there is one.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use wzvi::report::{Axis, Document, Figure, Look, Series};

use super::estimators::kubo;
use fixtures::folder;

fn page() -> Document {
    let report = kubo().paths(20).observe("<q> & \"q\"", |state| state.q[0]).run().unwrap();
    let line = (0..5000).map(|i| (f64::from(i), f64::from(i).sin())).collect();
    let figure = Figure::new("line", "A line & <marks>", Axis::linear("t"), Axis::linear("x"))
        .shows("It says \"what\" it shows.")
        .with(Series::new("a line", Look::Line, 0, line))
        .with(Series::new("constant", Look::Marks, 1, vec![(0.0, 1.0), (1.0, 1.0), (2.0, f64::NAN)]));
    report.append_to(Document::new("A page <for> tests").heading("Heading").figure(figure), "kubo")
}

#[test]
fn every_figure_has_its_table_and_nothing_is_fetched() {
    let html = page().html().unwrap();
    let dom = tl::parse(&html, tl::ParserOptions::default()).unwrap();
    let parser = dom.parser();
    let figures: Vec<_> = dom.query_selector("figure").unwrap().collect();
    assert_eq!(figures.len(), 3);
    for figure in figures {
        let tag = figure.get(parser).unwrap().as_tag().unwrap();
        for inner in ["h3", "svg", "figcaption", "table", "caption", "th"] {
            assert!(tag.query_selector(parser, inner).unwrap().next().is_some(), "a figure without {inner}");
        }
        let rows = tag.query_selector(parser, "tr").unwrap().count();
        assert!((4..=130).contains(&rows), "{rows} rows");
    }
    let mut names = HashSet::new();
    for tag in dom.nodes().iter().filter_map(|node| node.as_tag()) {
        let attribute = |name: &str| Some(tag.attributes().get(name)??.as_utf8_str().into_owned());
        for name in ["src", "href", "xlink:href", "srcset", "action", "data"] {
            if let Some(value) = attribute(name) {
                assert!(value.starts_with("data:") || value.starts_with('#'), "{name} = {value}");
            }
        }
        if let Some(id) = attribute("id") {
            assert!(names.insert(id.clone()), "two of {id}");
        }
        if tag.name() == "svg" {
            assert!(attribute("aria-label").is_some_and(|label| label.len() > 20));
        }
        if attribute("class").as_deref() == Some("point") {
            assert!(attribute("aria-label").is_some() && attribute("aria-label") == attribute("data-tip"));
        }
    }
    for word in ["@import", "url(", "fetch(", "XMLHttpRequest", "http://", "https://", "NaN,"] {
        assert!(!html.contains(word), "{word}");
    }
    assert!(html.contains("prefers-color-scheme: dark") && html.contains("A page &lt;for&gt; tests"));
}

/// Chromium under one of its names.
fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    names
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|path| path.is_file())
}

/// What the browser says on standard output and error.
fn open(browser: &Path, page: &Path, arguments: &[&str]) -> (String, String) {
    let profile = page.with_extension("profile");
    let output = Command::new(browser)
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"])
        .args(["--host-resolver-rules=MAP * ~NOTFOUND"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(arguments)
        .arg(format!("file://{}", page.display()))
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr))
}

/// Asks the page itself and writes the answers where the parsed document shows them.
const QUESTIONS: &str = "<script>
const answers = [], say = (text) => answers.push(text);
const tip = document.getElementById('tip'), points = [...document.querySelectorAll('.point')];
say('hidden:' + tip.hidden);
points[0].dispatchEvent(new PointerEvent('pointerover', { bubbles: true }));
say('hover:' + (!tip.hidden && tip.textContent === points[0].dataset.tip));
points[0].dispatchEvent(new PointerEvent('pointerout', { bubbles: true }));
say('out:' + tip.hidden);
const focusable = points.find((point) => point.hasAttribute('tabindex'));
focusable.focus();
say('focus:' + (document.activeElement === focusable));
focusable.dispatchEvent(new FocusEvent('focusin', { bubbles: true }));
say('shown:' + (!tip.hidden && tip.textContent.includes('strong error') === focusable.dataset.tip.includes('strong error')));
document.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' }));
say('escape:' + tip.hidden);
document.body.setAttribute('data-answers', answers.join(' '));
</script>";

#[test]
fn a_browser_shows_it() {
    let Some(browser) = browser() else {
        eprintln!("skipped: no Chromium on this machine");
        return;
    };
    let folder = folder!("browser");
    page().write(&folder).unwrap();
    let html = fs::read_to_string(folder.join("index.html")).unwrap();
    let asked = folder.join("asked.html");
    fs::write(&asked, html.replace("</body>", &format!("{QUESTIONS}</body>"))).unwrap();
    let (dom, log) = open(&browser, &asked, &["--dump-dom", "--window-size=1000,1600"]);
    let answers = "hidden:true hover:true out:true focus:true shown:true escape:true";
    let found = dom.split("data-answers=\"").nth(1).and_then(|rest| rest.split('"').next());
    assert_eq!(found, Some(answers), "{log}");
    assert!(!log.contains("CONSOLE"), "{log}");

    let [light, dark] = [("light", [255, 255, 255]), ("dark", [22, 24, 27])];
    for (width, columns, scheme) in [(390, 1, dark), (768, 1, light), (1280, 2, dark)] {
        shows_all_of_it(&browser, &folder, (width, columns), scheme);
    }
}

/// Asks whether all of the page is seen without scrolling sideways, all columns of its tables too where there is room, and how many figures are side
/// by side.
const FITS: &str = "<script>
const root = document.documentElement, [first, second] = [...document.querySelectorAll('figure')];
const fits = (table) => innerWidth < 1000 || table.closest('details') || table.scrollWidth <= table.clientWidth;
const tables = [...document.querySelectorAll('.table')].every(fits);
const columns = first.offsetTop === second.offsetTop ? 2 : 1;
document.body.setAttribute('data-fits', [root.scrollWidth <= innerWidth, tables, columns].join(' '));
</script>";

fn shows_all_of_it(
    browser: &Path,
    folder: &Path,
    (width, columns): (u32, u32),
    (scheme, ground): (&str, [u8; 3]),
) {
    let html = fs::read_to_string(folder.join("index.html")).unwrap();
    let asked = folder.join("fits.html");
    fs::write(&asked, html.replace("</body>", &format!("{FITS}</body>"))).unwrap();
    let shot = folder.join(format!("shot-{width}-{scheme}.png"));
    let number = if scheme == "dark" { 0 } else { 1 };
    let colours = format!("--blink-settings=preferredColorScheme={number}");
    let size = format!("--window-size={width},1600");
    let screenshot = format!("--screenshot={}", shot.display());
    let (dom, log) = open(browser, &asked, &["--dump-dom", &screenshot, &size, &colours]);
    let found = dom.split("data-fits=\"").nth(1).and_then(|rest| rest.split('"').next());
    assert_eq!(found, Some(format!("true true {columns}").as_str()), "{width} px: {log}");
    assert!(!log.contains("CONSOLE"), "{log}");
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(&shot).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.width, width);
    let colours: HashSet<_> = pixels.chunks(info.color_type.samples()).collect();
    assert!(colours.len() > 50, "{} colours in {} x {}", colours.len(), info.width, info.height);
    assert_eq!(pixels[..3], ground, "{scheme}");
}
