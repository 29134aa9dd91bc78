// The native part of the package `lacquer`. What users see is written in Python (src/python/lacquer), checks
// its arguments there, and calls this.
#include "python/module.h"

#include <pybind11/stl.h>

#include <array>

#include "pbrt/core/color_difference.h"
#include "pbrt/core/error.h"
#include "python/errors.h"

namespace py = pybind11;

PYBIND11_MODULE(_lacquer, m) {
    m.doc() = "Native part of lacquer; its functions are called by the package only.";
    m.attr("version") = LACQUER_VERSION;
    m.def("did_you_mean", [](const std::string& name, const std::vector<std::string>& known) {
        return lacquer::DidYouMean(name, known);
    });
    m.def("lab", [](double x, double y, double z, const std::array<double, 3>& white) {
        const lacquer::Lab lab = lacquer::LabOf({x, y, z}, {white[0], white[1], white[2]});
        return std::array{lab.L, lab.a, lab.b};
    });
    m.def("delta_e2000", [](const std::array<double, 3>& a, const std::array<double, 3>& b) {
        return lacquer::DeltaE2000({a[0], a[1], a[2]}, {b[0], b[1], b[2]});
    });
    lacquer::python::RegisterErrors();
    lacquer::python::DefineImages(m);
    lacquer::python::DefineScenes(m);
    lacquer::python::DefineMaterials(m);
}
