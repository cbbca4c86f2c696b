//! What peers print, read with care: where it is not as expected, nothing is found.

use super::Peer;

/// Milliseconds of tracing, where they are told.
///
/// POV-Ray: `Trace Time: 0 hours 0 minutes 1 seconds (1.234 seconds)`. Tachyon: `Ray Tracing Time:
/// 1.2345 seconds`.
pub fn trace_ms(peer: Peer, talk: &str) -> Option<f64> {
    let number = match peer {
        Peer::PovRay => {
            let (_, rest) = talk.split_once("Trace Time:")?;
            let (_, rest) = rest.lines().next()?.split_once('(')?;
            rest.strip_suffix("seconds)")?
        }
        Peer::Tachyon => {
            let (_, rest) = talk.split_once("Ray Tracing Time:")?;
            rest.lines().next()?.strip_suffix("seconds")?
        }
    };
    let seconds: f64 = number.trim().parse().ok()?;
    // To the microsecond, so that decimal places that nobody printed don't appear.
    (seconds.is_finite() && seconds >= 0.0).then_some((seconds * 1e6).round() / 1e3)
}

/// The version in the first line that calls it a ray tracer: `… Ray Tracer Version 3.7.0.10 …`.
pub fn version(talk: &str) -> Option<String> {
    let line = talk.lines().find(|line| line.contains("Ray Tracer"))?;
    let (_, rest) = line.split_once("Version ")?;
    rest.split_whitespace().next().map(str::to_owned)
}

/// The last line that says something.
pub fn last_words(talk: &str) -> &str {
    let lines = talk.lines().map(str::trim);
    lines.rev().find(|line| !line.is_empty()).unwrap_or("it said nothing")
}

#[cfg(test)]
mod tests {
    use super::*;

    const POV: &str = "Persistence of Vision(tm) Ray Tracer Version 3.7.0.10.unofficial (g++ @\n \
        x86_64)\nRender Time:\n  Photon Time:      No photons\n  Trace Time:       0 hours  1 \
        minutes  2 seconds (62.345 seconds)\n              using 2 thread(s)\nPOV-Ray finished\n\n";
    const TACHYON: &str = "Tachyon Parallel/Multiprocessor Ray Tracer   Version 0.99   \n\
        Copyright\nRendering Progress:       100% complete            \r  \n  Ray Tracing Time:     \
        0.0123 seconds\n    Image I/O Time:     0.0001 seconds\n";

    #[test]
    fn times_and_versions_are_found() {
        assert_eq!(trace_ms(Peer::PovRay, POV), Some(62345.0));
        assert_eq!(trace_ms(Peer::Tachyon, TACHYON), Some(12.3));
        assert_eq!(version(POV).as_deref(), Some("3.7.0.10.unofficial"));
        assert_eq!(version(TACHYON).as_deref(), Some("0.99"));
        assert_eq!(last_words(POV), "POV-Ray finished");
    }

    #[test]
    fn what_is_not_as_expected_is_nothing() {
        for peer in Peer::ALL {
            for talk in ["", "Trace Time: soon", "Ray Tracing Time:\n0.1 seconds", "Trace Time:"] {
                assert_eq!(trace_ms(peer, talk), None, "{talk}");
            }
        }
        assert_eq!(trace_ms(Peer::PovRay, &POV.replace("62.345", "62.3.45")), None);
        assert_eq!(trace_ms(Peer::PovRay, &POV.replace("62.345 ", "-1 ")), None);
        assert_eq!(trace_ms(Peer::Tachyon, &TACHYON.replace("0.0123", "nan")), None);
        assert_eq!(version("Ray Tracer"), None);
        assert_eq!(last_words("\n \n"), "it said nothing");
    }
}
