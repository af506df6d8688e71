//! The files of the page, which are built in.

/// A file of the page.
pub(crate) struct Asset {
    /// Its path in requests.
    pub(crate) path: &'static str,
    pub(crate) media_type: &'static str,
    pub(crate) body: &'static str,
}

macro_rules! page {
    ($file:literal) => {
        Asset {
            path: "/",
            media_type: "text/html; charset=utf-8",
            body: include_str!(concat!("../page/", $file)),
        }
    };
}

/// The page of a mission.
pub(crate) const MISSION: Asset = page!("index.html");
/// The page on which a mission is planned.
pub(crate) const PLANNING: Asset = page!("plan.html");

macro_rules! assets {
    ($($path:literal, $media_type:literal, $file:literal;)*) => {
        /// The files that pages ask for.
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
    "/style.css", "text/css; charset=utf-8", "style.css";
    "/plan.css", "text/css; charset=utf-8", "plan.css";
    "/icon.svg", "image/svg+xml", "icon.svg";
    "/leaflet.js", "text/javascript; charset=utf-8", "dist/leaflet.js";
    "/leaflet.css", "text/css; charset=utf-8", "dist/leaflet.css";
    "/leaflet.LICENSE.txt", "text/plain; charset=utf-8", "dist/leaflet.LICENSE.txt";
    "/mgrs.js", "text/javascript; charset=utf-8", "dist/mgrs.js";
    "/mgrs.LICENSE.txt", "text/plain; charset=utf-8", "dist/mgrs.LICENSE.txt";
    "/main.js", "text/javascript; charset=utf-8", "dist/main.js";
    "/areas.js", "text/javascript; charset=utf-8", "dist/areas.js";
    "/basemap.js", "text/javascript; charset=utf-8", "dist/basemap.js";
    "/chart.js", "text/javascript; charset=utf-8", "dist/chart.js";
    "/colors.js", "text/javascript; charset=utf-8", "dist/colors.js";
    "/controls.js", "text/javascript; charset=utf-8", "dist/controls.js";
    "/describe.js", "text/javascript; charset=utf-8", "dist/describe.js";
    "/end.js", "text/javascript; charset=utf-8", "dist/end.js";
    "/picture.js", "text/javascript; charset=utf-8", "dist/picture.js";
    "/finds.js", "text/javascript; charset=utf-8", "dist/finds.js";
    "/form.js", "text/javascript; charset=utf-8", "dist/form.js";
    "/fresh.js", "text/javascript; charset=utf-8", "dist/fresh.js";
    "/grid.js", "text/javascript; charset=utf-8", "dist/grid.js";
    "/kept.js", "text/javascript; charset=utf-8", "dist/kept.js";
    "/layers.js", "text/javascript; charset=utf-8", "dist/layers.js";
    "/map.js", "text/javascript; charset=utf-8", "dist/map.js";
    "/marks.js", "text/javascript; charset=utf-8", "dist/marks.js";
    "/measure.js", "text/javascript; charset=utf-8", "dist/measure.js";
    "/mission.js", "text/javascript; charset=utf-8", "dist/mission.js";
    "/orders.js", "text/javascript; charset=utf-8", "dist/orders.js";
    "/panel.js", "text/javascript; charset=utf-8", "dist/panel.js";
    "/pen.js", "text/javascript; charset=utf-8", "dist/pen.js";
    "/place.js", "text/javascript; charset=utf-8", "dist/place.js";
    "/player.js", "text/javascript; charset=utf-8", "dist/player.js";
    "/raster.js", "text/javascript; charset=utf-8", "dist/raster.js";
    "/readout.js", "text/javascript; charset=utf-8", "dist/readout.js";
    "/segments.js", "text/javascript; charset=utf-8", "dist/segments.js";
    "/sound.js", "text/javascript; charset=utf-8", "dist/sound.js";
    "/spread.js", "text/javascript; charset=utf-8", "dist/spread.js";
    "/status.js", "text/javascript; charset=utf-8", "dist/status.js";
    "/stream.js", "text/javascript; charset=utf-8", "dist/stream.js";
    "/plan/api.js", "text/javascript; charset=utf-8", "dist/plan/api.js";
    "/plan/drawing.js", "text/javascript; charset=utf-8", "dist/plan/drawing.js";
    "/plan/entries.js", "text/javascript; charset=utf-8", "dist/plan/entries.js";
    "/plan/fields.js", "text/javascript; charset=utf-8", "dist/plan/fields.js";
    "/plan/forecast.js", "text/javascript; charset=utf-8", "dist/plan/forecast.js";
    "/plan/list.js", "text/javascript; charset=utf-8", "dist/plan/list.js";
    "/plan/main.js", "text/javascript; charset=utf-8", "dist/plan/main.js";
    "/plan/map.js", "text/javascript; charset=utf-8", "dist/plan/map.js";
    "/plan/pen.js", "text/javascript; charset=utf-8", "dist/plan/pen.js";
    "/plan/save.js", "text/javascript; charset=utf-8", "dist/plan/save.js";
    "/plan/store.js", "text/javascript; charset=utf-8", "dist/plan/store.js";
    "/view.js", "text/javascript; charset=utf-8", "dist/view.js";
}

#[cfg(test)]
mod tests {
    use super::*;

    /// So that the page works without any other server.
    #[test]
    fn the_page_asks_for_nothing_but_its_own_files() {
        for asset in ASSETS.iter().chain([&MISSION, &PLANNING]) {
            // Of Leaflet: comments, and a link that the page does not show.
            let allowed = [
                "http://www.w3.org/2000/svg",
                "https://leafletjs.com",
                "https://bugs.chromium.org/p/chromium/issues/",
                "https://bugzilla.mozilla.org/show_bug.cgi",
            ];
            let links = asset.body.match_indices("http").map(|(start, _)| &asset.body[start..]);
            for link in links.filter(|link| link.starts_with("http://") || link.starts_with("https://")) {
                assert!(allowed.iter().any(|it| link.starts_with(it)), "{}: {link:.60}", asset.path);
            }
        }
        for page in [MISSION, PLANNING] {
            let page = page.body;
            for part in page.split("src=\"").skip(1).chain(page.split("href=\"").skip(1)) {
                let name = part.split('"').next().unwrap();
                let path = format!("/{}", name.trim_start_matches(['.', '/']));
                assert!(name.starts_with('#') || ASSETS.iter().any(|asset| asset.path == path), "{name}");
            }
        }
    }

    #[test]
    fn a_module_finds_all_that_it_imports() {
        let is_served = |path: &str| ASSETS.iter().any(|asset| asset.path == path);
        for asset in ASSETS.iter().filter(|asset| !["/leaflet.js", "/mgrs.js"].contains(&asset.path)) {
            let folder = asset.path.rsplit_once('/').unwrap().0;
            for name in asset.body.split("from \"").skip(1).filter_map(|rest| rest.split('"').next()) {
                let path = match (name.strip_prefix("../"), name.strip_prefix("./")) {
                    (Some(name), _) => format!("/{name}"),
                    (_, Some(name)) => format!("{folder}/{name}"),
                    _ => continue,
                };
                assert!(is_served(&path), "{} imports {name}", asset.path);
            }
        }
    }

    /// A library is only allowed with the text of its license.
    #[test]
    fn libraries_come_with_their_licenses_and_are_small() {
        let body = |path: &str| ASSETS.iter().find(|asset| asset.path == path).unwrap().body;
        for library in ["leaflet", "mgrs"] {
            assert!(body(&format!("/{library}.LICENSE.txt")).contains("Copyright (c)"), "{library}");
            assert!(body(&format!("/{library}.js")).len() > 1_000, "{library}");
        }
        let bytes: usize = ASSETS.iter().map(|asset| asset.body.len()).sum();
        assert!(bytes < 2_000_000, "{bytes} bytes");
    }
}
