#include "pbrt/film/exact_sums.h"

#include <algorithm>

#include "pbrt/core/check.h"

namespace lacquer {

int ExactSums::LevelOf(double x) {
    // |x| < 2^(exponent + 1) <= 2^(kBinWidth level + kBinWidth - 1).
    const int exponent = std::ilogb(x);
    const int level = (exponent + 1 - kBinWidth * kLowest) / kBinWidth + kLowest;
    return std::clamp(level, kLowest, kHighest);
}

void ExactSums::Raise(size_t i, int level) {
    Bins& bins = bins_[i];
    if (level == levels_[i] + 1)
        bins = {0, bins.high};
    else if (level > levels_[i])
        bins = {};
    levels_[i] = int8_t(std::max<int>(level, levels_[i]));
}

void ExactSums::Add(size_t to, const ExactSums& other, size_t from) {
    const int level = other.levels_[from];
    Raise(to, level);
    const Bins& bins = other.bins_[from];
    if (level == levels_[to]) {
        bins_[to].high += bins.high;
        bins_[to].low += bins.low;
    } else if (level + 1 == levels_[to]) {
        bins_[to].low += bins.high;
    }
}

void ExactSums::Add(const ExactSums& other) {
    LACQUER_CHECK(other.Size() == Size());
    for (size_t i = 0; i < Size(); ++i) Add(i, other, i);
}

bool ExactSums::HasValidLevels() const {
    return std::all_of(levels_.begin(), levels_.end(),
                       [](int8_t level) { return level >= kLowest && level <= kHighest; });
}

double ExactSums::operator[](size_t i) const {
    __extension__ using Wide = __int128;
    const Wide sum = Wide(bins_[i].high) * (int64_t(1) << kBinWidth) + bins_[i].low;
    return std::ldexp(double(sum), kBinWidth * (levels_[i] - 1));
}

}  // namespace lacquer
