#include "estimate/photo/flash_photo.h"

#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::estimate {
namespace {

using std::numbers::pi;

/// A row of a field, whether it has a number for each point or one for all.
class FieldRow {
  public:
    FieldRow(const Field& field, int row, std::span<double> scratch) {
        const size_t n = scratch.size();
        if (field.size() > 1) {
            values_ = &field[size_t(row) * n];
        } else {
            std::fill(scratch.begin(), scratch.end(), field[0]);
            values_ = scratch.data();
        }
    }
    double operator[](size_t j) const { return values_[j]; }

  private:
    const double* values_;
};

/// Adds a row of derivatives to those of a field.
void AddRow(std::span<const double> by, int row, Field* field) {
    if (field->size() > 1) {
        double* out = &(*field)[size_t(row) * by.size()];
        for (size_t j = 0; j < by.size(); ++j) out[j] += by[j];
    } else {
        double sum = 0;
        for (const double v : by) sum += v;
        (*field)[0] += sum;
    }
}

double Sum(std::span<const double> values) {
    double sum = 0;
    for (const double v : values) sum += v;
    return sum;
}

/// BackLobe() and its derivatives, by c and by a.
struct LobeGradient {
    double value, byC, byA;
};
inline LobeGradient BackLobeGradient(Brdf brdf, double c, double a) {
    const double c2 = c * c, u = 1 - c2 + a * c2, w = c2 + a * (1 - c2);
    const double inverseU = 1 / u;
    const bool isSmith = brdf == Brdf::Smith;
    const double value = a * inverseU * inverseU / ((4 * pi) * (isSmith ? std::sqrt(w) : c));
    const double byC = 4 * c * (1 - a) * inverseU - (isSmith ? c * (1 - a) / w : 1 / c);
    const double byA = 1 / a - 2 * c2 * inverseU - (isSmith ? 0.5 * (1 - c2) / w : 0);
    return {value, value * byC, value * byA};
}

/// One row of the image: what all reflectances share, and derivatives on the way back.
struct Row {
    int index = 0;
    double y = 0, distance = 0;
    std::vector<double> x;           ///< from the axis
    std::vector<double> irradiance;  ///< light / d^2 with the vignette
    std::array<std::vector<double>, 6> scratch;
    std::vector<double> byX, byY, byIrradiance, bySlopeX, bySlopeY, byRoughness;
    std::array<std::vector<double>, 3> byAlbedo;

    explicit Row(size_t n) {
        for (auto* v : {&x, &irradiance, &byX, &byY, &byIrradiance, &bySlopeX, &bySlopeY, &byRoughness})
            v->resize(n);
        for (auto& v : scratch) v.resize(n);
        for (auto& v : byAlbedo) v.resize(n);
    }
    size_t Size() const { return x.size(); }
    FromAxis<double> At(size_t j) const { return {x[j], y, distance}; }

    /// Takes derivatives by the cosine to those by slopes and place.
    void BackwardCosine(size_t j, double byC, double slopeX, double slopeY) {
        const double d2 = At(j).SquaredDistance(), n2 = 1 + slopeX * slopeX + slopeY * slopeY;
        const double w = x[j] * slopeX + y * slopeY + distance, q = 1 / std::sqrt(d2 * n2);
        const double by = w * q > kMinCosine ? byC * q : 0;
        bySlopeX[j] += by * (x[j] - slopeX * w / n2);
        bySlopeY[j] += by * (y - slopeY * w / n2);
        byX[j] += by * (slopeX - x[j] * w / d2);
        byY[j] += by * (slopeY - y * w / d2);
    }
};

void DielectricForward(Brdf brdf, const Surface& surface, Row* row, PlanarImage* linear) {
    const size_t n = row->Size(), first = size_t(row->index) * n;
    const FieldRow roughness(surface.roughness, row->index, row->scratch[0]);
    const FieldRow red(surface.albedo[0], row->index, row->scratch[1]);
    const FieldRow green(surface.albedo[1], row->index, row->scratch[2]);
    const FieldRow blue(surface.albedo[2], row->index, row->scratch[3]);
    double* out = &linear->values[first];
    const size_t plane = linear->NumPixels();
    for (size_t j = 0; j < n; ++j) {
        const std::array<double, 3> value =
            DielectricPixel<double>(brdf, row->At(j), surface.slopeX[first + j], surface.slopeY[first + j],
                                    roughness[j], {red[j], green[j], blue[j]});
        for (size_t k = 0; k < 3; ++k) out[k * plane + j] = row->irradiance[j] * value[k];
    }
}

void DielectricBackward(Brdf brdf, const Surface& surface, const PlanarImage& byLinear, Row* row) {
    const size_t n = row->Size(), first = size_t(row->index) * n, plane = byLinear.NumPixels();
    const FieldRow roughness(surface.roughness, row->index, row->scratch[0]);
    const FieldRow albedo[3] = {{surface.albedo[0], row->index, row->scratch[1]},
                                {surface.albedo[1], row->index, row->scratch[2]},
                                {surface.albedo[2], row->index, row->scratch[3]}};
    const double* by = &byLinear.values[first];
    for (size_t j = 0; j < n; ++j) {
        const double slopeX = surface.slopeX[first + j], slopeY = surface.slopeY[first + j];
        const double c = CosineAt(row->At(j), slopeX, slopeY), r2 = roughness[j] * roughness[j];
        const LobeGradient lobe = BackLobeGradient(brdf, c, r2 * r2);
        double all = 0, diffuse = 0;
        for (size_t k = 0; k < 3; ++k) {
            all += by[k * plane + j];
            diffuse += by[k * plane + j] * albedo[k][j];
            row->byAlbedo[k][j] = by[k * plane + j] * row->irradiance[j] * c / pi;
        }
        row->byIrradiance[j] = diffuse * c / pi + all * kDielectricF0 * lobe.value;
        row->byRoughness[j] = row->irradiance[j] * all * kDielectricF0 * lobe.byA * 4 * r2 * roughness[j];
        const double byC = row->irradiance[j] * (diffuse / pi + all * kDielectricF0 * lobe.byC);
        row->BackwardCosine(j, byC, slopeX, slopeY);
    }
}

void MetalForward(Brdf brdf, const Surface& surface, Row* row, PlanarImage* linear) {
    const size_t n = row->Size(), first = size_t(row->index) * n, plane = linear->NumPixels();
    double* out = &linear->values[first];
    for (size_t j = 0; j < n; ++j) {
        const double value =
            row->irradiance[j] * MetalPixel<double>(brdf, row->At(j), surface.slopeX[first + j],
                                                    surface.slopeY[first + j], surface.roughnessX,
                                                    surface.roughnessY);
        for (size_t k = 0; k < 3; ++k) out[k * plane + j] = surface.albedo[k][0] * value;
    }
}

/// AnisotropicBackLobe() and its derivatives.
struct MetalLobe {
    double value, byHx2, byHy2, byC2, byAlphaX, byAlphaY;
    MetalLobe(Brdf brdf, double hx2, double hy2, double c2, double alphaX, double alphaY)
        : value(AnisotropicBackLobe(brdf, hx2, hy2, c2, alphaX, alphaY)) {
        const double ax2 = alphaX * alphaX, ay2 = alphaY * alphaY;
        const double s = hx2 / ax2 + hy2 / ay2 + c2;
        const bool isSmith = brdf == Brdf::Smith;
        const double inverseW = 1 / (isSmith ? c2 + ax2 * hx2 + ay2 * hy2 : c2);
        const double masking = isSmith ? inverseW : 0;
        byHx2 = value * (-2 / (ax2 * s) - 0.5 * ax2 * masking);
        byHy2 = value * (-2 / (ay2 * s) - 0.5 * ay2 * masking);
        byC2 = value * (-2 / s - 0.5 * inverseW);
        byAlphaX = value * (-1 / alphaX + 4 * hx2 / (ax2 * alphaX * s) - alphaX * hx2 * masking);
        byAlphaY = value * (-1 / alphaY + 4 * hy2 / (ay2 * alphaY * s) - alphaY * hy2 * masking);
    }
};

void MetalBackward(Brdf brdf, const Surface& surface, const PlanarImage& byLinear, Row* row,
                   Surface* bySurface) {
    const size_t n = row->Size(), first = size_t(row->index) * n, plane = byLinear.NumPixels();
    const double alphaX = surface.roughnessX * surface.roughnessX, h = row->distance, y = row->y;
    const double alphaY = surface.roughnessY * surface.roughnessY;
    double byAlphaX = 0, byAlphaY = 0;
    for (size_t j = 0; j < n; ++j) {
        const double gx = surface.slopeX[first + j], gy = surface.slopeY[first + j], x = row->x[j];
        const double m = 1 + gy * gy, n2 = m + gx * gx, d2 = row->At(j).SquaredDistance();
        const double tx = y * gx * gy + h * gx - x * m, ty = h * gy - y;
        const double byTx = 2 * tx / (d2 * n2 * m), byTy = 2 * ty / (d2 * m);
        const double hx2 = 0.5 * byTx * tx, hy2 = 0.5 * byTy * ty, c = CosineAt(row->At(j), gx, gy);
        const MetalLobe lobe(brdf, hx2, hy2, c * c, alphaX, alphaY);
        double reflected = 0;
        for (size_t k = 0; k < 3; ++k) {
            const double by = byLinear.values[first + k * plane + j];
            reflected += by * surface.albedo[k][0];
            row->byAlbedo[k][j] = by * row->irradiance[j] * lobe.value;
        }
        row->byIrradiance[j] = reflected * lobe.value;
        const double scale = row->irradiance[j] * reflected, fx = scale * lobe.byHx2, fy = scale * lobe.byHy2;
        byAlphaX += scale * lobe.byAlphaX;
        byAlphaY += scale * lobe.byAlphaY;
        row->bySlopeX[j] += fx * (byTx * (y * gy + h) - 2 * hx2 * gx / n2);
        row->bySlopeY[j] += fx * (byTx * (y * gx - 2 * x * gy) - 2 * hx2 * gy * (1 / n2 + 1 / m)) +
                            fy * (byTy * h - 2 * hy2 * gy / m);
        row->byX[j] += -fx * (byTx * m + 2 * hx2 * x / d2) - fy * 2 * hy2 * x / d2;
        row->byY[j] += fx * (byTx * gx * gy - 2 * hx2 * y / d2) - fy * (byTy + 2 * hy2 * y / d2);
        row->BackwardCosine(j, scale * lobe.byC2 * 2 * c, gx, gy);
    }
    bySurface->roughnessX += byAlphaX * 2 * surface.roughnessX;
    bySurface->roughnessY += byAlphaY * 2 * surface.roughnessY;
}

double FourthPower(double r) { return r * r * r * r; }

/// What lies flat: the same for all channels but for the Lambertian part.
struct FlatLobes {
    double cosine;
    LobeGradient top, glow;
    FlatLobes(Brdf brdf, const Surface& surface, const FromAxis<double>& at)
        : cosine(at.distance / std::sqrt(at.SquaredDistance())),
          top(BackLobeGradient(brdf, cosine, FourthPower(surface.topRoughness))),
          glow(BackLobeGradient(brdf, cosine, FourthPower(surface.glowRoughness))) {}
    double Value(const Surface& s) const {
        return s.topF0 * top.value + s.glowWeight * s.glowF0 * glow.value;
    }
};

void FlakesForward(Brdf brdf, const Surface& surface, Row* row, PlanarImage* linear) {
    const size_t n = row->Size(), first = size_t(row->index) * n, plane = linear->NumPixels();
    const double a = FourthPower(surface.flakeRoughness);
    double* out = &linear->values[first];
    for (size_t j = 0; j < n; ++j) {
        const FlatLobes flat(brdf, surface, row->At(j));
        const double c = CosineAt(row->At(j), surface.slopeX[first + j], surface.slopeY[first + j]);
        const double value = flat.Value(surface), flake = BackLobe(brdf, c, a);
        for (size_t k = 0; k < 3; ++k)
            out[k * plane + j] = row->irradiance[j] * (surface.albedo[k][0] * flat.cosine / pi + value +
                                                       surface.flakeF0[k] * flake);
    }
}

void FlakesBackward(Brdf brdf, const Surface& surface, const PlanarImage& byLinear, Row* row, Surface* out) {
    const size_t n = row->Size(), first = size_t(row->index) * n, plane = byLinear.NumPixels();
    const double a = FourthPower(surface.flakeRoughness);
    double byTopA = 0, byGlowA = 0, byFlakeA = 0;
    for (size_t j = 0; j < n; ++j) {
        const double slopeX = surface.slopeX[first + j], slopeY = surface.slopeY[first + j];
        const FlatLobes flat(brdf, surface, row->At(j));
        const LobeGradient flake = BackLobeGradient(brdf, CosineAt(row->At(j), slopeX, slopeY), a);
        double all = 0, diffuse = 0, flakes = 0;
        for (size_t k = 0; k < 3; ++k) {
            const double by = byLinear.values[first + k * plane + j];
            all += by;
            diffuse += by * surface.albedo[k][0];
            flakes += by * surface.flakeF0[k];
            row->byAlbedo[k][j] = by * row->irradiance[j] * flat.cosine / pi;
            out->flakeF0[k] += by * row->irradiance[j] * flake.value;
        }
        row->byIrradiance[j] = diffuse * flat.cosine / pi + all * flat.Value(surface) + flakes * flake.value;
        const double e = row->irradiance[j], glow = surface.glowWeight * surface.glowF0;
        out->topF0 += e * all * flat.top.value;
        out->glowWeight += e * all * surface.glowF0 * flat.glow.value;
        out->glowF0 += e * all * surface.glowWeight * flat.glow.value;
        byTopA += e * all * surface.topF0 * flat.top.byA;
        byGlowA += e * all * glow * flat.glow.byA;
        byFlakeA += e * flakes * flake.byA;
        row->BackwardCosine(j, e * flakes * flake.byC, slopeX, slopeY);
        const double byFlat =
            e * (diffuse / pi + all * (surface.topF0 * flat.top.byC + glow * flat.glow.byC));
        const double byPlace = -byFlat * flat.cosine / row->At(j).SquaredDistance();
        row->byX[j] += byPlace * row->x[j];
        row->byY[j] += byPlace * row->y;
    }
    const auto byRoughness = [](double byA, double r) { return byA * 4 * r * r * r; };
    out->topRoughness += byRoughness(byTopA, surface.topRoughness);
    out->glowRoughness += byRoughness(byGlowA, surface.glowRoughness);
    out->flakeRoughness += byRoughness(byFlakeA, surface.flakeRoughness);
}

/// Coordinates and irradiance of the rows of a photograph, one after the other.
class Rows {
  public:
    Rows(const MapGrid& grid, double distance, const FlashSettings& settings)
        : grid_(grid), settings_(settings), row_(size_t(grid.size)), falloff_(size_t(grid.size)) {
        row_.distance = distance;
        for (size_t j = 0; j < falloff_.size(); ++j) {
            row_.x[j] = grid.X(int(j)) - settings.axisX;
            falloff_[j] = Falloff(row_.x[j]);
        }
    }
    Row& At(int index) {
        row_.index = index;
        row_.y = grid_.Y(index) - settings_.axisY;
        const double scale = settings_.light * Falloff(row_.y);
        for (size_t j = 0; j < falloff_.size(); ++j)
            row_.irradiance[j] = scale * falloff_[j] / row_.At(j).SquaredDistance();
        for (auto* v : {&row_.byX, &row_.byY, &row_.bySlopeX, &row_.bySlopeY})
            std::fill(v->begin(), v->end(), 0.);
        return row_;
    }

  private:
    double Falloff(double x) const {
        const double t = x / settings_.vignette;
        return std::exp(-0.5 * t * t);
    }
    MapGrid grid_;
    FlashSettings settings_;
    Row row_;
    std::vector<double> falloff_;
};

/// From irradiance and place to the settings, for one row.
void BackwardSettings(const FlashSettings& settings, Row* row, FlashSettings* by) {
    const double v2 = settings.vignette * settings.vignette;
    double light = 0, vignette = 0;
    for (size_t j = 0; j < row->Size(); ++j) {
        const double e = row->byIrradiance[j] * row->irradiance[j], x = row->x[j], y = row->y;
        const double byPlace = -e * (2 / row->At(j).SquaredDistance() + 1 / v2);
        light += e;
        vignette += e * (x * x + y * y);
        row->byX[j] += byPlace * x;
        row->byY[j] += byPlace * y;
    }
    by->light += light / settings.light;
    by->vignette += vignette / (v2 * settings.vignette);
    by->axisX -= Sum(row->byX);
    by->axisY -= Sum(row->byY);
}

}  // namespace

FlashPhoto::FlashPhoto(const MapGrid& grid, double distance, Brdf brdf)
    : grid_(grid), distance_(distance), brdf_(brdf) {
    LACQUER_CHECK(grid.size >= 2 && grid.extent > 0 && distance > 0);
}

void FlashPhoto::Forward(const Surface& surface, const FlashSettings& settings, PlanarImage* linear) const {
    if (linear->size != grid_.size || linear->values.empty()) *linear = PlanarImage(grid_.size);
    Rows rows(grid_, distance_, settings);
    for (int i = 0; i < grid_.size; ++i) {
        Row& row = rows.At(i);
        switch (surface.reflectance) {
            case Reflectance::Dielectric:
                DielectricForward(brdf_, surface, &row, linear);
                break;
            case Reflectance::Metal:
                MetalForward(brdf_, surface, &row, linear);
                break;
            case Reflectance::Flakes:
                FlakesForward(brdf_, surface, &row, linear);
                break;
        }
    }
}

void FlashPhoto::Backward(const Surface& surface, const FlashSettings& settings, const PlanarImage& byLinear,
                          Surface* bySurface, FlashSettings* bySettings) const {
    Rows rows(grid_, distance_, settings);
    for (int i = 0; i < grid_.size; ++i) {
        Row& row = rows.At(i);
        switch (surface.reflectance) {
            case Reflectance::Dielectric:
                DielectricBackward(brdf_, surface, byLinear, &row);
                break;
            case Reflectance::Metal:
                MetalBackward(brdf_, surface, byLinear, &row, bySurface);
                break;
            case Reflectance::Flakes:
                FlakesBackward(brdf_, surface, byLinear, &row, bySurface);
                break;
        }
        BackwardSettings(settings, &row, bySettings);
        AddRow(row.bySlopeX, i, &bySurface->slopeX);
        AddRow(row.bySlopeY, i, &bySurface->slopeY);
        if (surface.reflectance == Reflectance::Dielectric) AddRow(row.byRoughness, i, &bySurface->roughness);
        for (size_t k = 0; k < 3; ++k) AddRow(row.byAlbedo[k], i, &bySurface->albedo[k]);
    }
}

}  // namespace lacquer::estimate
