use super::*;

fn sample() -> String {
    let svg = "<svg width=\"9\" height=\"9\" xmlns=\"http://www.w3.org/2000/svg\"><rect/></svg>";
    page(
        "a < b & \"c\"",
        &[
            Section::new("First", [paragraph("1 < 2"), list(&["it's", "<script>"])]),
            Section::new(
                "<Second>",
                [
                    figure(svg, "a & b"),
                    table(&["name", "x"], &[vec!["<b>".to_owned(), "−1.5".to_owned()]]),
                    details("more", preformatted("a\n  b > c")),
                ],
            ),
        ],
    )
}

/// What is opened and not closed, or closed and not opened.
fn unbalanced(text: &str) -> Vec<String> {
    let mut open: Vec<String> = Vec::new();
    for tag in text.split('<').skip(1).map(|rest| rest.split('>').next().unwrap_or_default()) {
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap_or_default();
        let is_void = tag.ends_with('/') || ["meta", "!DOCTYPE"].contains(&name);
        if tag.starts_with('/') {
            if open.last().is_some_and(|last| last == name) {
                open.pop();
            } else {
                open.push(format!("/{name}"));
            }
        } else if !is_void {
            open.push(name.to_owned());
        }
    }
    open
}

#[test]
fn a_page_is_well_formed_and_fetches_nothing() {
    let text = sample();
    assert_eq!(unbalanced(&text), Vec::<String>::new(), "{text}");
    for outside in ["http", "src=", "url(", "@import", "<script", "<link"] {
        assert!(!text.contains(outside), "{outside} in\n{text}");
    }
    assert_eq!(unbalanced(&text.replacen("</p>", "", 1)).len() % 2, 1, "the check notices");
}

#[test]
fn text_is_escaped_and_numbers_are_set_to_the_right() {
    let text = sample();
    for part in [
        "<title>a &lt; b &amp; &quot;c&quot;</title>",
        "<p>1 &lt; 2</p>",
        "<li>it&#39;s</li>\n<li>&lt;script&gt;</li>",
        "<h2>&lt;Second&gt;</h2>",
        "<th>name</th><th class=\"number\">x</th>",
        "<td>&lt;b&gt;</td><td class=\"number\">−1.5</td>",
        "<pre>a\n  b &gt; c</pre>",
        "<svg width=\"9\" height=\"9\"><rect/></svg>",
    ] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
}

#[test]
fn the_colours_of_pictures_are_those_of_the_style_sheet() {
    for color in [INK, GRID, PAPER] {
        let [r, g, b] = color;
        let attribute = format!("[fill=\"#{r:02X}{g:02X}{b:02X}\"]");
        assert!(STYLE.contains(&attribute), "no {attribute}");
    }
}
