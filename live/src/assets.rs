//! The files of the page, which are built in.

/// A file of the page.
pub(crate) struct Asset {
    /// Its path in requests.
    pub(crate) path: &'static str,
    pub(crate) media_type: &'static str,
    pub(crate) body: &'static str,
}

macro_rules! assets {
    ($($path:literal, $media_type:literal, $file:literal;)*) => {
        pub(crate) const ASSETS: &[Asset] = &[
            $(Asset {
                path: $path,
                media_type: $media_type,
                body: include_str!(concat!("../page/", $file)),
            },)*
        ];
    };
}

assets! {
    "/", "text/html; charset=utf-8", "index.html";
    "/style.css", "text/css; charset=utf-8", "style.css";
    "/icon.svg", "image/svg+xml", "icon.svg";
    "/main.js", "text/javascript; charset=utf-8", "dist/main.js";
    "/chart.js", "text/javascript; charset=utf-8", "dist/chart.js";
    "/colors.js", "text/javascript; charset=utf-8", "dist/colors.js";
    "/controls.js", "text/javascript; charset=utf-8", "dist/controls.js";
    "/map.js", "text/javascript; charset=utf-8", "dist/map.js";
    "/mission.js", "text/javascript; charset=utf-8", "dist/mission.js";
    "/panel.js", "text/javascript; charset=utf-8", "dist/panel.js";
    "/player.js", "text/javascript; charset=utf-8", "dist/player.js";
    "/stream.js", "text/javascript; charset=utf-8", "dist/stream.js";
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So that the page works without any other server.
    #[test]
    fn the_page_asks_for_nothing_but_its_own_files() {
        for asset in ASSETS {
            let allowed = ["http://www.w3.org/2000/svg"];
            let links = asset.body.match_indices("http").map(|(start, _)| &asset.body[start..]);
            for link in links.filter(|link| link.starts_with("http://") || link.starts_with("https://")) {
                assert!(allowed.iter().any(|it| link.starts_with(it)), "{}: {link:.60}", asset.path);
            }
        }
        let page = ASSETS[0].body;
        for part in page.split("src=\"").skip(1).chain(page.split("href=\"").skip(1)) {
            let name = part.split('"').next().unwrap();
            let path = format!("/{}", name.trim_start_matches(['.', '/']));
            assert!(name.starts_with('#') || ASSETS.iter().any(|asset| asset.path == path), "{name}");
        }
    }
}
