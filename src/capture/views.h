// The photographs of a capture once their cameras are known: what the card gives, and what the fit takes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::capture {

/// In the frame of the card [cm]: its middle, x right, y up, z towards the cameras.
using Point = std::array<double, 3>;

/// How values of the images stand for linear ones.
enum class Response { Gamma22, SRGB, Linear };
/// What the response is to files of bytes.
ColorEncoding EncodingOf(Response response);

/// Of a light, in the units of ViewSet::lightPower; as far below 1 is the least.
inline constexpr double kMaxLightPower = 1e12;

/// A rectified photograph: a square of the sample, seen as from straight above, its rows from the top (from
/// large y), with the light that came to one camera from one point light.
struct View {
    std::string image;  ///< its file; a relative name is relative to that of the views
    Point camera{}, light{};
    bool isTest = false;  ///< held out of the fit
};

struct ViewSet {
    double size = 0;  ///< edge of the square of the sample that the images show [cm]
    Response response = Response::Gamma22;
    /// Intensity of the light [cm^2]: at a distance d, a white Lambertian surface straight on it has the
    /// linear value lightPower / (pi d^2).
    std::array<double, 3> lightPower{1500, 1500, 1500};
    std::vector<View> views;
};

}  // namespace lacquer::capture
