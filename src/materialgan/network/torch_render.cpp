#include "materialgan/network/torch_render.h"

#include <numbers>

namespace lacquer::materialgan {
namespace {

constexpr double kRenderEpsilon = 1e-6, kPhotoGamma = 2.2, kSlopeBeyond = 0.01;

Tensor Positions(const std::vector<capture::Point>& points) {
    Tensor tensor = torch::empty({int64_t(points.size()), 3}, torch::kFloat);
    float* out = tensor.data_ptr<float>();
    for (const capture::Point& point : points)
        for (const double x : point) *out++ = float(x);
    return tensor;
}

/// Of texels, 3 x R x R; rows from large y.
Tensor TexelPositions(int64_t resolution, double size, const torch::TensorOptions& options) {
    const Tensor t = ((torch::arange(resolution, options) + 0.5) / double(resolution) - 0.5) * size;
    const Tensor x = t.expand({resolution, resolution});
    return torch::stack({x, -x.t(), torch::zeros_like(x)});
}

Tensor ToLinear(const Tensor& stored) {
    // The derivative of a power is infinite at 0.
    return torch::pow((stored.clamp(-1, 1) + 1) * 0.5 + 1e-8, kPhotoGamma);
}

Tensor LengthOf(const Tensor& v, int64_t dimension) {
    return v.square().sum(dimension, /*keepdim=*/true).sqrt();
}

/// Over the third of five dimensions, what is below 0 as 0.
Tensor ClampedDot(const Tensor& a, const Tensor& b) { return (a * b).sum(2, /*keepdim=*/true).clamp_min(0); }

}  // namespace

TorchViews ViewsOf(const capture::ViewSet& set, bool ofTests) {
    std::vector<capture::Point> cameras, lights;
    for (const capture::View& view : set.views) {
        if (view.isTest != ofTests) continue;
        cameras.push_back(view.camera);
        lights.push_back(view.light);
    }
    const capture::Point power{set.lightPower[0], set.lightPower[1], set.lightPower[2]};
    return {Positions(cameras), Positions(lights), Positions({power})[0], set.size};
}

Tensor ClampMaps(const Tensor& maps, const GeneratorConfig& config) {
    const auto& [low, high] = config.roughnessRange;
    std::vector<Tensor> parts = maps.split_with_sizes({5, 1, 3}, 1);
    return torch::cat({parts[0].clamp(-1, 1), parts[1].clamp(low, high), parts[2].clamp(-1, 1)}, 1);
}

Tensor SoftClampMaps(const Tensor& maps, const GeneratorConfig& config) {
    const Tensor clamped = ClampMaps(maps, config);
    return clamped + kSlopeBeyond * (maps - clamped);
}

DecodedMaps DecodeMaps(const Tensor& maps) {
    const Tensor xy = maps.narrow(1, 3, 2).clamp(-1, 1);
    const Tensor z = (1 - xy.square().sum(1, /*keepdim=*/true).clamp(0, 1 - kRenderEpsilon)).sqrt();
    const Tensor normal = torch::cat({xy, z}, 1);
    return {ToLinear(maps.narrow(1, 0, 3)), normal / LengthOf(normal, 1), ToLinear(maps.narrow(1, 5, 1)),
            ToLinear(maps.narrow(1, 6, 3))};
}

Tensor RenderLinear(const Tensor& maps, const TorchViews& views) {
    const DecodedMaps decoded = DecodeMaps(maps);
    const Tensor a = decoded.albedo.unsqueeze(1), n = decoded.normal.unsqueeze(1),
                 r = decoded.roughness.unsqueeze(1), s = decoded.specular.unsqueeze(1);
    const Tensor p = TexelPositions(maps.size(-1), views.size, maps.options().requires_grad(false));
    const auto each = [](const Tensor& t) { return t.unsqueeze(-1).unsqueeze(-1).unsqueeze(0); };
    const Tensor toCamera = each(views.camera) - p, toLight = each(views.light) - p;
    const Tensor v = toCamera / LengthOf(toCamera, 2), distance = LengthOf(toLight, 2);
    const Tensor l = toLight / distance, between = v + l, h = between / LengthOf(between, 2);
    const Tensor nv = ClampedDot(n, v), nl = ClampedDot(n, l), nh = ClampedDot(n, h), vh = ClampedDot(v, h);
    const Tensor alpha = r.square(), alpha2 = alpha.square(), nh2 = nh.square();
    // nh2 (alpha2 - 1) + 1 without the difference of numbers that are nearly the same.
    const Tensor d = alpha2 / (std::numbers::pi * (nh2 * alpha2 + (1 - nh2)).square() + kRenderEpsilon);
    const Tensor f = s + (1 - s) * torch::exp2((-5.55473 * vh - 6.98316) * vh);
    const Tensor k = alpha * 0.5 + kRenderEpsilon;
    const auto shadowing = [&](const Tensor& c) { return c / (c * (1 - k) + k); };
    const Tensor specular = d * f * shadowing(nv) * shadowing(nl) / (4 * nv * nl + kRenderEpsilon);
    const Tensor power = views.power.dim() == 1 ? views.power.view({1, 1, 3, 1, 1}) : each(views.power);
    return power * (a * (1 - s) / std::numbers::pi + specular) * nl / distance.square();
}

Tensor EncodeLinear(const Tensor& linear) {
    return torch::pow(linear.clamp(kRenderEpsilon, 1), 1 / kPhotoGamma);
}

Tensor RenderEncoded(const Tensor& maps, const TorchViews& views) {
    return EncodeLinear(RenderLinear(maps, views));
}

}  // namespace lacquer::materialgan
