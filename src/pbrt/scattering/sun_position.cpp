#include "pbrt/scattering/sun_position.h"

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <regex>

namespace lacquer {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
double Sin(double degrees) { return std::sin(degrees * kDegree); }
double Cos(double degrees) { return std::cos(degrees * kDegree); }
/// Into [0, 360).
double Wrap(double degrees) {
    const double wrapped = std::fmod(degrees, 360);
    return wrapped < 0 ? wrapped + 360 : wrapped;
}

}  // namespace

std::optional<Instant> ParseInstant(const std::string& text) {
    static const std::regex pattern(
        R"((\d{4})-(\d\d)-(\d\d)[ T](\d\d):(\d\d)(?::(\d\d(?:\.\d+)?))? ?(?:(Z)|([+-])(\d\d):?(\d\d))?)");
    std::smatch match;
    if (!std::regex_match(text, match, pattern)) return {};
    const auto number = [&](size_t i) { return match[i].matched ? std::atof(match[i].str().c_str()) : 0.0; };
    const std::chrono::year_month_day date(std::chrono::year(int(number(1))),
                                           std::chrono::month(unsigned(number(2))),
                                           std::chrono::day(unsigned(number(3))));
    if (!date.ok() || number(4) > 23 || number(5) > 59 || number(6) >= 60 || number(9) > 14 ||
        number(10) > 59)
        return {};
    const double zone = (match[8].str() == "-" ? -1 : 1) * (number(9) + number(10) / 60);
    const double hours = number(4) + number(5) / 60 + number(6) / 3600 - zone;
    const auto days = double(std::chrono::sys_days(date).time_since_epoch().count());
    return Instant{2440587.5 + days + hours / 24};  // the day of 1 January 1970, 0 h
}

SunPosition SunPositionAt(Instant instant, double latitude, double longitude) {
    const double n = instant.julianDay - 2451545.0;  // days since noon of 1 January 2000
    const double meanLongitude = 280.460 + 0.9856474 * n, anomaly = 357.528 + 0.9856003 * n;
    const double ecliptic = meanLongitude + 1.915 * Sin(anomaly) + 0.020 * Sin(2 * anomaly);
    const double obliquity = 23.439 - 4e-7 * n;
    const double ascension = std::atan2(Cos(obliquity) * Sin(ecliptic), Cos(ecliptic)) / kDegree;
    const double sinDeclination = Sin(obliquity) * Sin(ecliptic);
    const double cosDeclination = std::sqrt(1 - sinDeclination * sinDeclination);
    const double siderealTime = 280.46062 + 360.98564737 * n + longitude;
    const double hourAngle = siderealTime - ascension;

    const double up = Sin(latitude) * sinDeclination + Cos(latitude) * cosDeclination * Cos(hourAngle);
    const double east = -cosDeclination * Sin(hourAngle);
    const double north = Cos(latitude) * sinDeclination - Sin(latitude) * cosDeclination * Cos(hourAngle);
    return {std::atan2(up, std::hypot(east, north)) / kDegree, Wrap(std::atan2(east, north) / kDegree)};
}

}  // namespace lacquer
