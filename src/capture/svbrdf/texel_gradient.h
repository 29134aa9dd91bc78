// The model of svbrdf_model.h in single precision for eight texels at a time, with the derivatives of the
// squared differences from photographs: backward, by hand, since most of the nine derivatives of each
// intermediate result would be zero (35 ns for a texel and a photograph; dual numbers take 370).
// tests/capture/svbrdf/texel_gradient_test.cpp holds it to the model with dual numbers.
#pragma once

#include "capture/svbrdf/lanes.h"
#include "capture/svbrdf/svbrdf_model.h"

namespace lacquer::capture {

using TexelLanes = Texel<Lanes>;
using StoredLanes = StoredTexel<Lanes>;
using ColorLanes = std::array<Lanes, 3>;
using VectorLanes = std::array<Lanes, 3>;

inline Lanes Dot3(const VectorLanes& a, const VectorLanes& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Decode() with what its derivatives take.
struct DecodedLanes {
    TexelLanes texel;
    StoredLanes
        slope;    ///< of linear values, and of alpha, by stored ones; of z before its scaling by x and y
    Lanes scale;  ///< of the normal
};

inline DecodedLanes DecodeLanes(const StoredLanes& t) {
    constexpr auto kGamma = float(kModelGamma);
    DecodedLanes d;
    const auto decode = [&](size_t c) {
        const Lanes u = 0.5F * t[c] + 0.5F, power = PowLanes(u, kGamma - 1);
        d.slope[c] = (0.5F * kGamma) * power;
        return u * power;
    };
    for (size_t c = 0; c < 3; ++c) {
        d.texel.albedo[c] = decode(kAlbedo + c);
        d.texel.specular[c] = decode(kSpecular + c);
    }
    const Lanes roughness = decode(kRoughness);
    d.texel.alpha = roughness * roughness;
    d.slope[kRoughness] *= 2 * roughness;
    const Lanes x = t[kNormal], y = t[kNormal + 1], xy2 = x * x + y * y;
    constexpr auto kMaxXY2 = float(1 - kModelEpsilon);
    const Lanes z = SqrtLanes(1.F - MinLanes(xy2, AllLanes(kMaxXY2))), inverse = 1.F / z;
    d.slope[kNormal] = xy2 < kMaxXY2 ? -x * inverse : Lanes{};
    d.slope[kNormal + 1] = xy2 < kMaxXY2 ? -y * inverse : Lanes{};
    d.scale = 1.F / SqrtLanes(xy2 + z * z);
    d.texel.normal = {x * d.scale, y * d.scale, z * d.scale};
    return d;
}

/// Derivatives by stored values from those by what they stand for.
inline StoredLanes ByStored(const DecodedLanes& d, const TexelLanes& by) {
    StoredLanes gradient;
    for (size_t c = 0; c < 3; ++c) {
        gradient[kAlbedo + c] = by.albedo[c] * d.slope[kAlbedo + c];
        gradient[kSpecular + c] = by.specular[c] * d.slope[kSpecular + c];
    }
    gradient[kRoughness] = by.alpha * d.slope[kRoughness];
    // Of a derivative by the normal, only the part across it is left by its scaling.
    const VectorLanes& n = d.texel.normal;
    const Lanes along = Dot3(by.normal, n), byZ = (by.normal[2] - along * n[2]) * d.scale;
    for (size_t i = 0; i < 2; ++i)
        gradient[kNormal + i] = (by.normal[i] - along * n[i]) * d.scale + byZ * d.slope[kNormal + i];
    return gradient;
}

/// Directions at eight texels of a row.
struct GeometryLanes {
    VectorLanes toCamera, toLight, half;
    Lanes falloff;  ///< 1 / d^2 [1/cm^2]
    Lanes weight;   ///< SchlickWeight()
};

/// @param x  of the texels, @param y  of their row [cm]
inline GeometryLanes GeometryOfLanes(const Lanes& x, float y, const Point& camera, const Point& light) {
    const auto difference = [&](const Point& p) -> VectorLanes {
        return {float(p[0]) - x, AllLanes(float(p[1]) - y), AllLanes(float(p[2]))};
    };
    const auto scaled = [](const VectorLanes& p, const Lanes& s) -> VectorLanes {
        return {p[0] * s, p[1] * s, p[2] * s};
    };
    const VectorLanes v = difference(camera), l = difference(light);
    GeometryLanes g;
    g.falloff = 1.F / Dot3(l, l);
    g.toCamera = scaled(v, 1.F / SqrtLanes(Dot3(v, v)));
    g.toLight = scaled(l, SqrtLanes(g.falloff));
    const VectorLanes sum{g.toCamera[0] + g.toLight[0], g.toCamera[1] + g.toLight[1],
                          g.toCamera[2] + g.toLight[2]};
    g.half = scaled(sum, 1.F / SqrtLanes(Dot3(sum, sum)));
    const Lanes vh = MaxLanes(Dot3(g.toCamera, g.half), Lanes{});
    g.weight = Exp2Lanes((-5.55473F * vh - 6.98316F) * vh);
    return g;
}

/// FacetLobe() with its derivatives.
struct FacetLanes {
    Lanes value, byNV, byNL, byNH, byAlpha;
};

/// @param sine2  the square of the sine of the angle whose cosine is nh: of narrow lobes it has the digits
inline FacetLanes FacetLobeLanes(const Lanes& nv, const Lanes& nl, const Lanes& nh, const Lanes& sine2,
                                 const Lanes& alpha) {
    constexpr auto kEpsilon = float(kModelEpsilon), kPi = std::numbers::pi_v<float>;
    const Lanes alpha2 = alpha * alpha, nh2 = nh * nh, u = nh2 * alpha2 + sine2;
    const Lanes inverseD = 1.F / (kPi * u * u + kEpsilon), D = alpha2 * inverseD;
    const Lanes byU = -2 * kPi * u * D * inverseD;
    const Lanes k = 0.5F * alpha + kEpsilon;
    const Lanes inverseV = 1.F / (nv * (1.F - k) + k), inverseL = 1.F / (nl * (1.F - k) + k);
    const Lanes gV = nv * inverseV, gL = nl * inverseL;
    const Lanes inverse = 1.F / (4 * nv * nl + kEpsilon), common = D * inverse;
    FacetLanes f;
    f.value = common * gV * gL;
    f.byNV = common * gL * k * inverseV * inverseV - 4 * nl * inverse * f.value;
    f.byNL = common * gV * k * inverseL * inverseL - 4 * nv * inverse * f.value;
    const Lanes G = gV * gL * inverse;
    f.byNH = G * byU * 2 * nh * (alpha2 - 1.F);
    const Lanes byK = -common * (gL * gV * (1.F - nv) * inverseV + gV * gL * (1.F - nl) * inverseL);
    f.byAlpha = G * (2 * alpha * inverseD + byU * 2 * alpha * nh2) + 0.5F * byK;
    return f;
}

/// What eight texels have summed over the photographs so far.
struct SumsLanes {
    Lanes squares{};       ///< of differences
    TexelLanes byTexel{};  ///< derivatives of the squares
    ColorLanes byPower{};  ///< by the logarithms of the light's power
};

/// Derivative of a square of a difference by the linear value. Where the photograph's range ends it is 0,
/// unless the difference calls the value back: else what is too bright would stay so.
inline Lanes AddSquare(const Lanes& linear, const Lanes& seen, const Lanes& isUsed, Lanes* squares) {
    constexpr auto kLow = float(kModelEpsilon);
    const Lanes inside = ClampLanes(linear, kLow, 1);
    const Lanes power =
        PowLanes(inside, float(1 / kModelGamma - 1));  // the encoded value over the linear one
    const Lanes difference = (inside * power - seen) * isUsed;
    *squares += difference * difference;
    const Lanes slope = float(2 / kModelGamma) * difference * power;
    const Lanes above = linear > 1.F ? MaxLanes(slope, Lanes{}) : slope;
    return linear < kLow ? MinLanes(above, Lanes{}) : above;
}

/// Adds a photograph.
/// @param seen  its encoded values    @param isUsed  1, or 0 for lanes without a texel
inline void AddPhotograph(const TexelLanes& t, const GeometryLanes& g, const std::array<float, 3>& power,
                          const ColorLanes& seen, const Lanes& isUsed, SumsLanes* sums) {
    constexpr auto kInvPi = std::numbers::inv_pi_v<float>;
    const VectorLanes &n = t.normal, &h = g.half;
    const Lanes dotV = Dot3(n, g.toCamera), dotL = Dot3(n, g.toLight), dotH = Dot3(n, h), zero{};
    const Lanes nv = MaxLanes(dotV, zero), nl = MaxLanes(dotL, zero), nh = MaxLanes(dotH, zero);
    const VectorLanes cross{n[1] * h[2] - n[2] * h[1], n[2] * h[0] - n[0] * h[2], n[0] * h[1] - n[1] * h[0]};
    const Lanes sine2 = dotH > zero ? Dot3(cross, cross) : AllLanes(1);
    const FacetLanes lobe = FacetLobeLanes(nv, nl, nh, sine2, t.alpha);

    Lanes byLobe{}, byNL{};
    for (size_t c = 0; c < 3; ++c) {
        const Lanes &a = t.albedo[c], &s = t.specular[c];
        const Lanes F = s + (1.F - s) * g.weight, light = power[c] * g.falloff;
        const Lanes f = a * (1.F - s) * kInvPi + lobe.value * F, linear = light * nl * f;
        const Lanes byLinear = AddSquare(linear, seen[c], isUsed, &sums->squares);
        const Lanes byValue = byLinear * light, byF = byValue * nl;
        sums->byTexel.albedo[c] += byF * (1.F - s) * kInvPi;
        sums->byTexel.specular[c] += byF * (lobe.value * (1.F - g.weight) - a * kInvPi);
        sums->byPower[c] += byLinear * linear;
        byLobe += byF * F;
        byNL += byValue * f;
    }
    sums->byTexel.alpha += byLobe * lobe.byAlpha;
    const Lanes byV = dotV > zero ? byLobe * lobe.byNV : zero;
    const Lanes byL = dotL > zero ? byLobe * lobe.byNL + byNL : zero;
    const Lanes byH = dotH > zero ? byLobe * lobe.byNH : zero;
    for (size_t i = 0; i < 3; ++i)
        sums->byTexel.normal[i] += byV * g.toCamera[i] + byL * g.toLight[i] + byH * h[i];
}

}  // namespace lacquer::capture
