// Intel Open Image Denoise, where Lacquer was built with it.
#pragma once

#include "denoise/planes.h"
#include "pbrt/core/progress.h"

namespace lacquer::denoise {

/// True if it was there when Lacquer was built.
bool HasOidn();

/// Filters `color` with the guides, all of one size. The guides have noise of their own: each is filtered
/// first by itself, and then counts as free of noise (the library's "cleanAux").
/// @param threads   that the library may use; what else it takes for its results is its own
/// @param observer  hears of the progress; may be null
/// Errors: std::runtime_error with the library's own message, and where HasOidn() is false.
Color FilterByOidn(const Color& color, const Color& albedo, const Color& normal, int threads,
                   Observer* observer);

}  // namespace lacquer::denoise
