// The figures of the report on fitted tables, as SVG elements with images inside.
#pragma once

#include <string>
#include <vector>

#include "gaussfit/fit/lobe_fit.h"

namespace lacquer::cmd {

/// Slices of a model over alpha and angle, each with the table's lobes over it.
std::string SliceGallery(const gaussfit::LobeTable& table, const gaussfit::LobeFitOptions& options);

/// A transmission, a reflection and their product: the functions in the first row, the fitted lobes in the
/// second one, as in [Xia et al. 2020] figure 7.
std::string ProductFigure(const gaussfit::LobeTable& transmission, const gaussfit::LobeTable& reflection);

/// One kind of error over alpha and the angle, for each of the survey's indices.
struct ErrorKind {
    const char* title;
    const char* unit;
    double gaussfit::LobeError::*field;
    double full;  ///< the lightest colour
};
const std::vector<ErrorKind>& ErrorKinds();
std::string ErrorMap(const gaussfit::LobeTable& table, const gaussfit::LobeSurvey& survey,
                     const ErrorKind& kind, size_t eta);

/// The scale of colours from 0 to `full`.
std::string ColorScale(const ErrorKind& kind);

}  // namespace lacquer::cmd
