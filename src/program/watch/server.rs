//! The page of `lampyris watch`: its files, news of the script, and pictures, for a browser on the
//! same machine.

use std::io::Cursor;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use tiny_http::{Header, Method, Request, Response, Server};

use crate::error::{Error, Result};
use crate::program::screen::Screen;

/// How long a question for news waits for some: shorter than browsers' patience.
const PATIENCE: Duration = Duration::from_secs(20);

/// Questions that wait at a time: tabs of one person.
const MOST_REQUESTS: usize = 64;

type Answer = Response<Cursor<Vec<u8>>>;

/// Serves the page in threads of its own, for as long as the program lives.
///
/// Errors: a port that cannot be had.
pub(super) fn serve(screen: Arc<Screen>, port: u16) -> Result<SocketAddr> {
    let refused = |problem: String| Error::inconsistent("watch: port", problem);
    let server = Server::http((Ipv4Addr::LOCALHOST, port)).map_err(|e| refused(e.to_string()))?;
    let address = server.server_addr().to_ip().ok_or_else(|| refused("is no port".to_owned()))?;
    std::thread::spawn(move || {
        let places = Arc::new(());
        for request in server.incoming_requests() {
            let (screen, place) = (Arc::clone(&screen), Arc::clone(&places));
            if Arc::strong_count(&places) > MOST_REQUESTS {
                let _ = request.respond(refusal(503));
                continue;
            }
            std::thread::spawn(move || {
                let answer = answer(&screen, &request, address.port());
                // The browser may have gone.
                let _ = request.respond(answer);
                drop(place);
            });
        }
    });
    Ok(address)
}

fn answer(screen: &Screen, request: &Request, port: u16) -> Answer {
    if !is_from_here(request, port) {
        return refusal(403);
    }
    if *request.method() != Method::Get {
        return refusal(405);
    }
    match request.url() {
        "/" => file("text/html; charset=utf-8", include_str!("page.html")),
        "/page.js" => file("text/javascript; charset=utf-8", include_str!("page.js")),
        "/page.css" => file("text/css; charset=utf-8", include_str!("page.css")),
        url => match (number_after(url, "/news/"), number_after(url, "/picture/")) {
            (Some(version), _) => {
                let news = screen.wait_for_news(version, PATIENCE);
                file("application/json", news.to_string())
            }
            (_, Some(version)) => match screen.picture(version) {
                Some(png) => file("image/png", png.to_vec()),
                None => refusal(404),
            },
            _ => refusal(404),
        },
    }
}

fn number_after(url: &str, start: &str) -> Option<u64> {
    url.strip_prefix(start)?.parse().ok()
}

/// Whether a page of ours asks: other sites reach this address by names of theirs, or are named by
/// the browser as who asks.
fn is_from_here(request: &Request, port: u16) -> bool {
    let value = |name: &'static str| {
        let mut all = request.headers().iter().filter(|header| header.field.equiv(name));
        all.next().map(|header| header.value.as_str())
    };
    let hosts = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let is_ours = |host: &str| hosts.iter().any(|our| our.eq_ignore_ascii_case(host));
    value("Host").is_some_and(is_ours)
        && value("Sec-Fetch-Site").is_none_or(|site| matches!(site, "same-origin" | "none"))
        && value("Origin").is_none_or(|origin| origin.strip_prefix("http://").is_some_and(is_ours))
}

const HEADERS: [(&str, &str); 5] = [
    ("Content-Security-Policy", "default-src 'self'; base-uri 'none'; frame-ancestors 'none'"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("X-Content-Type-Options", "nosniff"),
    ("Cache-Control", "no-store"),
];

fn file(kind: &'static str, content: impl Into<Vec<u8>>) -> Answer {
    let headers = HEADERS.into_iter().chain([("Content-Type", kind)]);
    let headers = headers.filter_map(|(name, value)| Header::from_bytes(name, value).ok());
    headers.fold(Response::from_data(content), Response::with_header)
}

fn refusal(code: u16) -> Answer {
    file("text/plain", "").with_status_code(code)
}
