#include "bulk/input/particles_json.h"

#include <cmath>

#include "bulk/input/particles_input.h"
#include "bulk/table/bulk_problem.h"

namespace lacquer::bulk {

double ParticlesJson::Positive(const std::string& pointer, double high, const char* what) const {
    const Json& value = At(pointer);
    const double number = value.is_number() ? value.get<double>() : 0;
    if (!(number > 0 && number <= high))
        Fail(pointer, fmt::format("found {}; expected {}", KindOf(value), what));
    return number;
}

double ParticlesJson::Whole(const std::string& pointer, double low, double high) const {
    const double number = Number(pointer, low, high);
    if (number != std::floor(number))
        Fail(pointer, fmt::format("found {}; expected a whole number", KindOf(At(pointer))));
    return number;
}

size_t ParticlesJson::NumItems(const std::string& pointer, const char* what) const {
    const Json& list = At(pointer);
    if (!list.is_array() || list.empty())
        Fail(pointer, fmt::format("found {}; expected {}", KindOf(list), what));
    return list.size();
}

double ParticlesJson::LengthAt(const std::string& pointer, const char* what) const {
    constexpr double kLowest = 1e-4, kHighest = 1e5;
    const double length = unit_ * Positive(pointer, 1e300, what);
    if (length < kLowest || length > kHighest)
        Fail(pointer, fmt::format("found {}, which is {:g} um; expected a length from {:g} to {:g} um",
                                  KindOf(At(pointer)), length, kLowest, kHighest));
    return length;
}

void ParticlesJson::CheckSize(const std::string& at, const BulkSettings& s, double radius) const {
    const double largest = s.method == BulkMethod::Clusters ? kMaxSizeParameter : 5 * kMaxSizeParameter;
    const double x = radius * WavenumberOf(s, s.wavelengths.front());
    if (x > largest)
        Fail(at, fmt::format("the largest radius, {:.4g} um, has the size parameter {:.4g} at {:g} nm; "
                             "expected at most {:g}",
                             radius, x, s.wavelengths.front(), largest));
}

}  // namespace lacquer::bulk
