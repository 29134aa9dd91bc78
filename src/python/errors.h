// What the library throws, as exceptions of Python.
#pragma once

#include <pybind11/pybind11.h>

#include <stdexcept>
#include <string>

namespace lacquer::python {

/// An argument that makes no sense: lacquer.UsageError.
class UsageError : public std::invalid_argument {
  public:
    using std::invalid_argument::invalid_argument;
};

/// Makes errors of the library exceptions of the package: lacquer.SceneError, FileError and UsageError, with
/// the text that the command line shows and the places.
void RegisterErrors();

}  // namespace lacquer::python
