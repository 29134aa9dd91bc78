// The denoisers by name, and images denoised by one of them.
#pragma once

#include <string>
#include <vector>

#include "denoise/planes.h"
#include "pbrt/core/progress.h"
#include "pbrt/image/image.h"

namespace lacquer::denoise {

enum class Method {
    Nfor,  ///< our own (denoiser.h)
    Oidn   ///< Intel Open Image Denoise (oidn.h), where it was built in
};

/// All of them, built in or not: "nfor", "oidn".
std::vector<std::string> MethodNames();
/// @param name  one of MethodNames()
Method MethodOf(const std::string& name);
/// Why a denoiser cannot be had in this build; empty: it can.
std::string WhyUnavailable(Method method);

/// Auxiliary outputs (--aov) that it needs beside colours.
std::vector<std::string> AovsOf(Method method);
/// Those that were asked for, and what the denoiser needs: all that a render has to keep.
std::vector<std::string> WithAovsOf(Method method, std::vector<std::string> aovs);
/// Why a render cannot be denoised, as the end of a sentence about it; empty: it can.
/// @param samples     in each pixel
/// @param hasSplats   it has light that is traced from the lights
std::string WhyNot(Method method, int samples, bool hasSplats);

/// What is known of the noise that is left.
struct NoiseReport {
    Planes<1> variance;  ///< in each pixel, as Denoised::noise; empty: nothing is known
    float before = 0, after = 0;
    bool IsKnown() const { return !variance.IsEmpty(); }
};

/// Denoises the channels R, G and B of an image with those of AovsOf(method).
/// @param observer  hears of the progress; may be null
/// Errors, with the image as it was: std::invalid_argument with what is missing, or why the image will not
/// do; std::runtime_error where a library fails.
NoiseReport DenoiseImage(Method method, Image* image, Observer* observer);

}  // namespace lacquer::denoise
