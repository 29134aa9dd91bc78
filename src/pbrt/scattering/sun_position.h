// Where the sun is in the sky.
#pragma once

#include <optional>
#include <string>

namespace lacquer {

/// An instant of time, by the Julian day: fractional days since noon of 1 January 4713 BC at Greenwich.
struct Instant {
    double julianDay = 0;
};
/// "2026-06-21 15:30", with seconds or without, at most a "T" between date and time, and at the end "Z" or
/// the zone: "+02:00", "-0330". Without a zone it is that of Greenwich. Empty for all else, and for dates
/// that do not exist.
std::optional<Instant> ParseInstant(const std::string& text);

/// Angles [degrees].
struct SunPosition {
    double elevation = 0;  ///< over the horizon, without refraction
    double azimuth = 0;    ///< clockwise from north, in [0, 360)
};
/// To 0.02 degrees between the years 1950 and 2050: the low-precision formulas of the Astronomical Almanac.
/// @param latitude, longitude  [degrees], north and east are positive
SunPosition SunPositionAt(Instant instant, double latitude, double longitude);

}  // namespace lacquer
