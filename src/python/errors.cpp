#include "python/errors.h"

#include <algorithm>
#include <exception>
#include <new>
#include <vector>

#include "pbrt/base/film.h"
#include "pbrt/core/error.h"

namespace lacquer::python {

namespace py = pybind11;

namespace {

/// Sets an exception of the package. Texts may quote bytes of files that are no UTF-8.
void Raise(const char* type, const std::string& text, const std::vector<Diagnostic>& diagnostics) {
    const auto decode = [](const std::string& bytes) {
        PyObject* decoded = PyUnicode_DecodeUTF8(bytes.data(), Py_ssize_t(bytes.size()), "replace");
        if (!decoded) throw py::error_already_set();
        return py::reinterpret_steal<py::str>(decoded);
    };
    py::list places;
    for (const Diagnostic& d : diagnostics)
        places.append(py::make_tuple(decode(d.loc.file), d.loc.line, d.loc.column, decode(d.message)));
    const py::object cls = py::module_::import("lacquer._errors").attr(type);
    const py::object error = cls(decode(text), places);
    PyErr_SetObject(cls.ptr(), error.ptr());
}

void Translate(std::exception_ptr pending) {
    try {
        std::rethrow_exception(pending);
    } catch (const SceneErrors& e) {
        const auto& all = e.Diagnostics();
        const bool filesOnly = std::all_of(
            all.begin(), all.end(), [](const Diagnostic& d) { return d.cause == Diagnostic::Cause::File; });
        Raise(filesOnly ? "FileError" : "SceneError", e.what(), all);
    } catch (const SceneError& e) {
        Raise("SceneError", e.what(), {{Diagnostic::Severity::Error, e.Loc(), e.Message()}});
    } catch (const FileError& e) {
        Raise("FileError", e.what(),
              {{Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::File}});
    } catch (const OverrideError& e) {
        Raise("UsageError", e.what(), {});
    } catch (const std::invalid_argument& e) {
        Raise("UsageError", e.what(), {});
    } catch (const std::bad_alloc&) {
        PyErr_SetString(PyExc_MemoryError, "not enough memory for this scene");
    }
}

}  // namespace

void RegisterErrors() { py::register_exception_translator(Translate); }

}  // namespace lacquer::python
