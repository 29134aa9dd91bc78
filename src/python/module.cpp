// The native part of the package `lacquer`. What users see is written in Python (src/python/lacquer), checks
// its arguments there, and calls this.
#include "python/module.h"

#include "pbrt/core/error.h"
#include "python/errors.h"

namespace py = pybind11;

PYBIND11_MODULE(_lacquer, m) {
    m.doc() = "Native part of lacquer; its functions are called by the package only.";
    m.attr("version") = LACQUER_VERSION;
    m.def("did_you_mean", [](const std::string& name, const std::vector<std::string>& known) {
        return lacquer::DidYouMean(name, known);
    });
    lacquer::python::RegisterErrors();
    lacquer::python::DefineImages(m);
    lacquer::python::DefineScenes(m);
    lacquer::python::DefineMaterials(m);
}
