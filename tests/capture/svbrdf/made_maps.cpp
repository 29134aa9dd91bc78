#include "capture/svbrdf/made_maps.h"

#include <cmath>

#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/core/rng.h"

namespace lacquer::capture::test {
namespace {

double Uniform(Rng* rng, double low, double high) { return low + (high - low) * double(rng->Uniform()); }

/// Smooth values in [0,1] between those of a lattice that repeats.
class ValueNoise {
  public:
    ValueNoise(int n, uint64_t seed) : n_(n) {
        Rng rng(seed);
        for (int i = 0; i < n * n; ++i) values_.push_back(double(rng.Uniform()));
    }
    double At(double x, double y) const {
        const double i = std::floor(x * n_), j = std::floor(y * n_);
        const double fx = Smooth(x * n_ - i), fy = Smooth(y * n_ - j);
        const auto row = [&](int k) { return Value(int(i), k) * (1 - fx) + Value(int(i) + 1, k) * fx; };
        return row(int(j)) * (1 - fy) + row(int(j) + 1) * fy;
    }

  private:
    static double Smooth(double t) { return t * t * (3 - 2 * t); }
    double Value(int i, int j) const {
        return values_[size_t(((j % n_ + n_) % n_) * n_ + (i % n_ + n_) % n_)];
    }
    int n_;
    std::vector<double> values_;
};

/// Linear values of one of the two materials.
struct Base {
    double albedo[3], specular[3], roughness;
    explicit Base(Rng* rng) {
        const bool isMetal = rng->Uniform() < 0.25F;
        const double reflectance = isMetal ? Uniform(rng, 0.5, 0.8) : 0.04;
        roughness = Uniform(rng, 0.25, 0.75);
        for (size_t c = 0; c < 3; ++c) {
            albedo[c] = isMetal ? Uniform(rng, 0, 0.05) : Uniform(rng, 0.05, 0.65);
            specular[c] = isMetal ? reflectance * Uniform(rng, 0.6, 1) : reflectance;
        }
    }
};

class Maker {
  public:
    Maker(Pattern pattern, uint64_t seed)
        : pattern_(pattern),
          rng_(Hash(seed, int(pattern))),
          coarse_(4, Hash(seed, 1)),
          medium_(8, Hash(seed, 2)),
          fine_(16, Hash(seed, 3)),
          rough_(16, Hash(seed, 4)),
          bases_{Base(&rng_), Base(&rng_)} {}

    /// @param x, y  in [0,1], y downwards
    StoredTexel<double> At(double x, double y) const {
        const double w = Share(x, y), vary = 1 + 0.3 * (fine_.At(x, y) - 0.5);
        const auto mix = [&](double a, double b) { return a * (1 - w) + b * w; };
        StoredTexel<double> t;
        for (size_t c = 0; c < 3; ++c) {
            t[kAlbedo + c] = StoredOf(mix(bases_[0].albedo[c], bases_[1].albedo[c]) * vary);
            t[kSpecular + c] = StoredOf(mix(bases_[0].specular[c], bases_[1].specular[c]));
        }
        t[kRoughness] =
            StoredOf(mix(bases_[0].roughness, bases_[1].roughness) * (1 + 0.2 * (rough_.At(x, y) - 0.5)));
        constexpr double kStep = 1e-3;
        const double hx = (Height(x + kStep, y) - Height(x - kStep, y)) / (2 * kStep);
        const double hy = (Height(x, y - kStep) - Height(x, y + kStep)) / (2 * kStep);
        const double scale = 1 / std::sqrt(1 + hx * hx + hy * hy);
        t[kNormal] = -hx * scale;
        t[kNormal + 1] = -hy * scale;
        return t;
    }

  private:
    /// Distance to the nearest joint over the tile's edge.
    static double FromJoint(double x, double y) {
        const double tx = 4 * x - std::floor(4 * x), ty = 4 * y - std::floor(4 * y);
        return std::min(std::min(tx, 1 - tx), std::min(ty, 1 - ty));
    }
    /// Of the second material.
    double Share(double x, double y) const {
        if (pattern_ == Pattern::Tiles) return FromJoint(x, y) < 0.1 ? 1 : 0;
        if (pattern_ == Pattern::Waves) return medium_.At(x, y);
        const double f = 0.6 * coarse_.At(x, y) + 0.3 * medium_.At(x, y) + 0.1 * fine_.At(x, y);
        return 1 / (1 + std::exp(-40 * (f - 0.5)));
    }
    double Height(double x, double y) const {
        double height = 0.02 * fine_.At(x, y) + 0.06 * medium_.At(x, y);
        if (pattern_ == Pattern::Tiles) height += 0.02 * std::min(1., FromJoint(x, y) / 0.12);
        if (pattern_ == Pattern::Waves) height += 0.01 * std::sin(40 * x + 6 * coarse_.At(x, y));
        return height;
    }

    Pattern pattern_;
    Rng rng_;
    ValueNoise coarse_, medium_, fine_, rough_;
    Base bases_[2];
};

}  // namespace

Maps MadeMaps(int size, Pattern pattern, uint64_t seed) {
    Maps maps(size);
    const Maker maker(pattern, seed);
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) {
            const auto texel = maker.At((column + 0.5) / size, (row + 0.5) / size);
            for (size_t c = 0; c < kNumChannels; ++c)
                maps.Channel(c)[size_t(row) * size_t(size) + size_t(column)] = texel[c];
        }
    return maps;
}

Maps RandomMaps(int size, uint64_t seed) {
    Maps maps(size);
    Rng rng(Hash(seed, 5));
    for (size_t c = 0; c < kNumChannels; ++c)
        for (double& value : maps.Channel(c))
            value = c == kNormal || c == kNormal + 1 ? Uniform(&rng, -0.5, 0.5) : Uniform(&rng, -1, 1);
    return maps;
}

ViewSet GridViews(int count) {
    ViewSet views;
    views.size = 6.848;
    std::vector<Point> grid;
    for (const double y : {2.5, 0., -2.5})
        for (const double x : {-2.5, 0., 2.5}) grid.push_back({x, y, 16});
    const std::vector<size_t> chosen = count == 1   ? std::vector<size_t>{4}
                                       : count == 3 ? std::vector<size_t>{0, 5, 7}
                                       : count == 5 ? std::vector<size_t>{4, 0, 2, 6, 8}
                                                    : std::vector<size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8};
    for (const size_t i : chosen) views.views.push_back({"", grid[i], grid[i], false});
    return views;
}

std::vector<View> NovelViews() {
    std::vector<View> views;
    for (const double x : {-1.25, 1.25})
        for (const double y : {-1.25, 1.25}) views.push_back({"", {x, y, 14}, {x, y, 14}, true});
    for (const double x : {-6., 6.})
        for (const double y : {-6., 6.}) views.push_back({"", {0, 0, 16}, {x, y, 10}, true});
    return views;
}

std::vector<RectifiedImage> RenderViews(const Maps& maps, const ViewSet& views) {
    std::vector<RectifiedImage> images;
    for (const View& view : views.views) images.push_back(RenderView(maps, views, view));
    return images;
}

double NovelRmse(const Maps& a, const Maps& b, const ViewSet& views) {
    double sum = 0;
    const std::vector<View> novel = NovelViews();
    for (const View& view : novel) {
        const double rmse = Rmse(RenderView(a, views, view), RenderView(b, views, view));
        sum += rmse * rmse;
    }
    return std::sqrt(sum / double(novel.size()));
}

}  // namespace lacquer::capture::test
