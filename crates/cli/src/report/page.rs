//! Frame of reports as one HTML file: style inside, nothing fetched.

use super::table::escaped;
use super::viewer;

const STYLE: &str = include_str!("report.css");

/// Begins a page with its title and its summary.
pub(super) fn page_start(title: &str, summary: &str) -> String {
    let (title, summary) = (escaped(title), escaped(summary));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"lead\">{summary}</p>\n",
        viewer::STYLE,
    )
}

/// Returns a section of a page.
pub(super) fn section(title: &str, content: &str) -> String {
    format!("<section>\n<h2>{}</h2>\n{content}</section>\n", escaped(title))
}

/// Ends a page.
pub(super) fn page_end() -> String {
    let version = env!("CARGO_PKG_VERSION");
    format!("<footer>musculo-collide {version}</footer>\n</body>\n</html>\n")
}
