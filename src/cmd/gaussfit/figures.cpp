#include "cmd/gaussfit/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "cmd/gaussfit/images.h"

namespace lacquer::cmd {

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180;

/// A rectangle in the plane of slopes.
struct Frame2 {
    double x0, x1, y0, y1;
    double X(double t) const { return x0 + t * (x1 - x0); }
    double Y(double t) const { return y1 - t * (y1 - y0); }  // images begin at the top
};

/// An image of a density; roots of values, so that tails show.
struct Tile {
    Frame2 frame;
    std::vector<double> values;
    int width, height;

    Tile(const Frame2& f, int w, int h, const std::function<double(double, double)>& density)
        : frame(f), values(size_t(w) * size_t(h)), width(w), height(h) {
        for (int j = 0; j < h; ++j)
            for (int i = 0; i < w; ++i)
                values[size_t(j) * size_t(w) + size_t(i)] = density(f.X((i + 0.5) / w), f.Y((j + 0.5) / h));
    }
    double Sum() const { return std::accumulate(values.begin(), values.end(), 0.0); }
    /// An SVG image at a place.
    std::string Svg(double x, double y, double w, double h) const {
        ColorImage image(width, height);
        const double largest = std::max(1e-300, *std::max_element(values.begin(), values.end()));
        for (int j = 0; j < height; ++j)
            for (int i = 0; i < width; ++i)
                image.SetValue(
                    i, j, std::sqrt(std::max(0.0, values[size_t(j) * size_t(width) + size_t(i)]) / largest));
        return fmt::format(
            "<image x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" "
            "preserveAspectRatio=\"none\" "
            "href=\"{}\"/>\n",
            x, y, w, h, image.DataUri());
    }
};

/// The part of two densities that they share, each normalised: 1 if they are equal.
double Overlap(const Tile& a, const Tile& b) {
    const double sumA = a.Sum(), sumB = b.Sum();
    double sum = 0;
    for (size_t i = 0; i < a.values.size(); ++i) sum += std::min(a.values[i] / sumA, b.values[i] / sumB);
    return sum;
}

std::string Text(double x, double y, const char* style, const std::string& text) {
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" class=\"{}\">{}</text>\n", x, y, style, text);
}

std::string Svg(double width, double height, const std::string& label, const std::string& content) {
    return fmt::format("<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{}\">\n{}</svg>\n",
                       width, height, label, content);
}

/// Ellipses at one and two standard deviations of each part of a lobe, in a tile at (x, y).
std::string Ellipses(const gaussfit::SliceMixture& mixture, const Frame2& f, double x, double y, double w,
                     double h) {
    const double sx = w / (f.x1 - f.x0), sy = h / (f.y1 - f.y0);
    std::string svg;
    for (int i = 0; i < mixture.count; ++i) {
        const gaussfit::SliceGaussian& g = mixture.parts[size_t(i)];
        for (const int deviations : {1, 2})
            svg += fmt::format(
                "<ellipse cx=\"{:.2f}\" cy=\"{:.2f}\" rx=\"{:.2f}\" ry=\"{:.2f}\" class=\"part{} s{}\"/>\n",
                x + (g.meanX - f.x0) * sx, y + f.y1 * sy, deviations * std::sqrt(g.varianceX) * sx,
                deviations * std::sqrt(g.varianceY) * sy, i, deviations);
    }
    return svg;
}

/// The angles of a gallery's columns.
std::vector<gaussfit::SlicePoint> GalleryPoints(const gaussfit::LobeModel& model,
                                                const gaussfit::LobeFitOptions& options, double alpha) {
    std::vector<gaussfit::SlicePoint> points;
    for (const double position : {0.0, 0.35, 0.65, 0.85, 1.0}) {
        gaussfit::SlicePoint p;
        p.alpha = alpha;
        p.eta = !model.Transmits() ? 1 : model.event == gaussfit::LobeEvent::Leaving ? 1 / 1.5 : 1.5;
        const double end = options.maxThetaDeg * kDegree;
        p.theta = model.event == gaussfit::LobeEvent::Leaving
                      ? std::asin(std::sin(std::asin(options.maxSine) * position) * p.eta)
                      : std::min(end, position < 1 ? 90 * kDegree * position : end);
        points.push_back(p);
    }
    return points;
}

constexpr double kTileWidth = 176, kTileHeight = 96;

/// A number for people: three digits, a true minus, no -0.
std::string Number(double value) {
    std::string text = fmt::format("{:.3g}", std::abs(value) < 1e-9 ? 0.0 : value);
    if (text[0] == '-') text.replace(0, 1, "−");
    return text;
}

/// One slice with its lobes, and what there is to say about it below.
std::string GalleryTile(const gaussfit::LobeTable& table, const gaussfit::LobeFitOptions& options,
                        const gaussfit::SlicePoint& point, double x, double y) {
    const gaussfit::LobeModel& model = *table.Get().model;
    const gaussfit::SliceFit fit = gaussfit::FitSliceAt(model, point, options);
    if (fit.slice.IsEmpty()) return {};
    const gaussfit::SliceMixture fitted = gaussfit::MixtureOf(table, point);
    const Frame2 frame{fit.slice.x0, fit.slice.x1, -fit.slice.y1, fit.slice.y1};
    const Tile tile(frame, 88, 48,
                    [&](double sx, double sy) { return gaussfit::SliceValue(model, point, sx, sy); });
    // An inner <svg> cuts off what sticks out of the tile.
    std::string svg = fmt::format("<svg x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\">\n", x, y,
                                  kTileWidth, kTileHeight);
    svg += tile.Svg(0, 0, kTileWidth, kTileHeight) + Ellipses(fitted, frame, 0, 0, kTileWidth, kTileHeight) +
           "</svg>\n";
    svg += Text(x, y + kTileHeight + 13, "note",
                fmt::format("x {} … {},  y ± {}", Number(frame.x0), Number(frame.x1), Number(frame.y1)));
    const gaussfit::LobeError error = gaussfit::ErrorOf(fit, fitted);
    return svg + Text(x, y + kTileHeight + 26, "note",
                      fmt::format("{:.0f} % covered, {:.4f} nat lost", 100 * (1 - error.uncovered),
                                  std::max(0.0, error.lostLikelihood)));
}

}  // namespace

std::string SliceGallery(const gaussfit::LobeTable& table, const gaussfit::LobeFitOptions& options) {
    constexpr double kWidth = kTileWidth, kHeight = kTileHeight, kGapX = 14, kGapY = 46, kLeft = 66,
                     kTop = 26;
    const gaussfit::LobeModel& model = *table.Get().model;
    const std::vector<double> alphas = {0.02, 0.1, 0.3, 0.8};
    std::string svg;
    for (size_t row = 0; row < alphas.size(); ++row) {
        const std::vector<gaussfit::SlicePoint> points = GalleryPoints(model, options, alphas[row]);
        const double y = kTop + double(row) * (kHeight + kGapY);
        svg += Text(0, y + kHeight / 2 + 4, "label", fmt::format("α = {}", alphas[row]));
        for (size_t column = 0; column < points.size(); ++column) {
            const double x = kLeft + double(column) * (kWidth + kGapX);
            if (row == 0)
                svg += Text(x, kTop - 9, "label",
                            fmt::format("θ = {}°", Number(points[column].theta / kDegree)));
            svg += GalleryTile(table, options, points[column], x, y);
        }
    }
    return Svg(kLeft + 5 * (kWidth + kGapX), kTop + double(alphas.size()) * (kHeight + kGapY),
               fmt::format("Slices of {} with the fitted lobes", model.name), svg);
}

std::string ProductFigure(const gaussfit::LobeTable& transmission, const gaussfit::LobeTable& reflection) {
    constexpr double kSize = 220, kGapX = 26, kGapY = 44, kTop = 24, kLeft = 84;
    constexpr int kPixels = 110;
    constexpr float kAlphaT = 0.3f, kAlphaR = 0.3f, kEta = 1.5f;
    const gaussfit::LobeModel &t = *transmission.Get().model, &r = *reflection.Get().model;
    const Vec3 above = SphericalDirection(std::sin(Radians(65.f)), std::cos(Radians(65.f)), 0);
    const Vec3 inside = SphericalDirection(std::sin(Radians(30.f)), std::cos(Radians(30.f)), Radians(245.f));
    const auto value = [](const gaussfit::LobeModel& model, float alpha, Vec3 w, double x, double y,
                          int power) {
        const Vec3 v = DirectionOf({float(x), float(y)}, model.Transmits() ? -1.f : 1.f);
        return double(model.f(alpha, kEta, w, v)) * std::pow(std::abs(double(v.z)), power);
    };
    gaussfit::GaussianMixture lobeT, lobeR;
    if (!transmission.Find(kAlphaT, kEta, above, &lobeT) || !reflection.Find(kAlphaR, kEta, inside, &lobeR))
        return {};
    const gaussfit::GaussianMixtureProduct product = gaussfit::Multiply(lobeT, lobeR);

    const Frame2 frame{-1.4, 1.8, -1.2, 2.0};
    const auto tile = [&](const std::function<double(double, double)>& density) {
        return Tile(frame, kPixels, kPixels, density);
    };
    const std::vector<Tile> exact = {
        tile([&](double x, double y) { return value(t, kAlphaT, above, x, y, t.cosinePower); }),
        tile([&](double x, double y) { return value(r, kAlphaR, inside, x, y, r.cosinePower); }),
        tile([&](double x, double y) {
            return value(t, kAlphaT, above, x, y, 4) * value(r, kAlphaR, inside, x, y, 0);
        })};
    const auto pdf = [](const auto& mixture) {
        return [&mixture](double x, double y) { return double(mixture.Pdf({float(x), float(y)})); };
    };
    const std::vector<Tile> fitted = {tile(pdf(lobeT)), tile(pdf(lobeR)), tile(pdf(product))};

    const char* titles[] = {"transmission", "reflection", "product"};
    std::string svg = Text(0, kTop + kSize / 2, "label", "function");
    svg += Text(0, kTop + kSize * 1.5 + kGapY, "label", "lobes");
    for (size_t i = 0; i < 3; ++i) {
        const double x = kLeft + double(i) * (kSize + kGapX);
        svg += Text(x, kTop - 8, "label", titles[i]);
        svg += exact[i].Svg(x, kTop, kSize, kSize) + fitted[i].Svg(x, kTop + kSize + kGapY, kSize, kSize);
        const auto percent = [](const Tile& a, const Tile& b) {
            return fmt::format("{:.0f} %", 100 * Overlap(a, b));
        };
        const double y = kTop + kSize + 16;
        if (i == 2) {
            svg += Text(x, y, "note", percent(exact[2], fitted[2]) + " in common with the lobes' product");
        } else {
            svg += Text(x, y, "note", percent(exact[i], fitted[i]) + " in common with its lobe,");
            svg += Text(x, y + 14, "note", percent(exact[2], fitted[i]) + " of the product with that lobe");
        }
    }
    return Svg(kLeft + 3 * kSize + 2 * kGapX, kTop + 2 * kSize + kGapY,
               fmt::format("Product of {} and {}", t.name, r.name), svg);
}

const std::vector<ErrorKind>& ErrorKinds() {
    static const std::vector<ErrorKind> kinds = {
        {"error of the mean", "σ", &gaussfit::LobeError::meanInSigmas, 0.1},
        {"error of log L11", "", &gaussfit::LobeError::logL11, 0.2},
        {"likelihood lost", "nat", &gaussfit::LobeError::lostLikelihood, 0.05},
        {"slice not covered", "", &gaussfit::LobeError::uncovered, 0.5},
    };
    return kinds;
}

std::string ErrorMap(const gaussfit::LobeTable& table, const gaussfit::LobeSurvey& survey,
                     const ErrorKind& kind, size_t eta) {
    constexpr double kWidth = 210, kHeight = 120, kLeft = 30, kTop = 4, kBottom = 20;
    const int columns = int(survey.alphas.size()), rows = int(survey.angles.size());
    ColorImage image(columns, rows);
    double largest = 0;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const size_t i = survey.Index(eta, size_t(column), size_t(rows - 1 - row));
            const double value = survey.errors[i].*kind.field;
            largest = std::max(largest, value);
            image.SetValue(column, row, value / kind.full);
        }
    std::string svg = fmt::format(
        "<image class=\"cells\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\" "
        "href=\"{}\"/>\n",
        kLeft, kTop, kWidth, kHeight, image.DataUri());

    // Axes: alpha to the right, the angle upward.
    const double first = std::log(survey.alphas.front()), last = std::log(survey.alphas.back());
    for (const double alpha : {0.01, 0.1, 1.0}) {
        const double t = (std::log(alpha) - first) / (last - first) * (columns - 1) + 0.5;
        svg += Text(kLeft + std::min(t / columns, 1.0) * kWidth, kTop + kHeight + 14, "note middle",
                    fmt::format("{}", alpha));
    }
    for (const int row : {0, rows / 2, rows - 1}) {
        const double theta = survey.fits[survey.Index(eta, 0, size_t(row))].point.theta / kDegree;
        svg += Text(kLeft - 4, kTop + kHeight * (1 - (row + 0.5) / rows) + 4, "note end",
                    fmt::format("{:.0f}°", theta));
    }
    svg += Text(kLeft + 6, kTop + 15, "inside", fmt::format("max {:.2g}", largest));
    return Svg(kLeft + kWidth + 8, kTop + kHeight + kBottom,
               fmt::format("{}: {} over alpha and angle", table.Get().model->name, kind.title), svg);
}

std::string ColorScale(const ErrorKind& kind) {
    constexpr int kSteps = 64;
    ColorImage image(kSteps, 1);
    for (int i = 0; i < kSteps; ++i) image.SetValue(i, 0, (i + 0.5) / kSteps);
    std::string svg = fmt::format(
        "<image x=\"30\" y=\"2\" width=\"210\" height=\"10\" preserveAspectRatio=\"none\" href=\"{}\"/>\n",
        image.DataUri());
    svg += Text(30, 26, "note", "0");
    svg += Text(240, 26, "note end", fmt::format("≥ {} {}", kind.full, kind.unit));
    return Svg(248, 30, fmt::format("Colours of {}", kind.title), svg);
}

}  // namespace lacquer::cmd
