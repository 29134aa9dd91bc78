// Images: in numpy's arrays and in files.
#include <pybind11/numpy.h>

#include <algorithm>
#include <cstring>

#include "denoise/method.h"
#include "pbrt/film/aov.h"
#include "python/errors.h"
#include "python/interruptible.h"
#include "python/module.h"

namespace lacquer::python {

namespace py = pybind11;

namespace {

/// Rows, columns, channels.
using Floats = py::array_t<float, py::array::c_style | py::array::forcecast>;

py::array_t<float> ArrayOf(const Image& image) {
    py::array_t<float> array({image.Resolution().y, image.Resolution().x, image.NumChannels()});
    std::copy(image.Pixels().begin(), image.Pixels().end(), array.mutable_data());
    return array;
}

py::object ValueOf(const MetadataValue& value) {
    if (const auto* matrix = std::get_if<glm::mat4>(&value)) {
        py::array_t<float> array({4, 4});
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column) array.mutable_at(row, column) = (*matrix)[column][row];
        return array;
    }
    if (const auto* text = std::get_if<std::string>(&value)) {
        PyObject* decoded = PyUnicode_DecodeUTF8(text->data(), Py_ssize_t(text->size()), "replace");
        if (!decoded) throw py::error_already_set();
        return py::reinterpret_steal<py::object>(decoded);
    }
    if (const auto* integer = std::get_if<int>(&value)) return py::int_(*integer);
    if (const auto* number = std::get_if<float>(&value)) return py::float_(*number);
    return py::cast(std::get<std::vector<float>>(value));
}

py::dict MetadataOf(const Image& image) {
    py::dict metadata;
    for (const auto& [name, value] : image.metadata) metadata[py::str(name)] = ValueOf(value);
    return metadata;
}

glm::mat4 MatrixOf(const Floats& array) {
    glm::mat4 matrix(0);
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) matrix[column][row] = array.at(row, column);
    return matrix;
}

MetadataValue MetadataValueOf(const std::string& name, const py::handle& value) {
    try {
        if (py::isinstance<py::str>(value)) return value.cast<std::string>();
        if (py::isinstance<py::int_>(value)) return value.cast<int>();
        if (py::isinstance<py::float_>(value)) return value.cast<float>();
        if (py::isinstance<py::array>(value)) {
            const auto array = value.cast<Floats>();
            if (array.ndim() == 2 && array.shape(0) == 4 && array.shape(1) == 4) return MatrixOf(array);
        }
        return value.cast<std::vector<float>>();
    } catch (const py::cast_error&) {
        throw UsageError("metadata \"" + name +
                         "\": expected a text, an integer of 32 bits, a number, numbers, or a 4 x 4 array");
    }
}

Image ImageOf(const Floats& pixels, const std::vector<std::string>& channels, const py::dict& metadata) {
    if (pixels.ndim() != 3 || size_t(pixels.shape(2)) != channels.size())
        throw UsageError("expected an array of rows, columns, and as many channels as there are names");
    const py::ssize_t height = pixels.shape(0), width = pixels.shape(1);
    if (height < 1 || width < 1 || height > kMaxImageSide || width > kMaxImageSide || channels.empty() ||
        channels.size() > size_t(kMaxImageChannels))
        throw UsageError("an image has 1 to " + std::to_string(kMaxImageSide) +
                         " rows and columns and 1 to " + std::to_string(kMaxImageChannels) + " channels");
    Image image(Int2(int(width), int(height)), channels);
    std::copy_n(pixels.data(), pixels.size(), image.Pixels().begin());
    for (const auto& [name, value] : metadata) {
        const auto key = name.cast<std::string>();
        image.metadata[key] = MetadataValueOf(key, value);
    }
    return image;
}

std::shared_ptr<Image> Read(const std::string& path, const std::string& encoding) {
    const auto parsed = ColorEncoding::Parse(encoding);
    if (!parsed)
        throw UsageError("encoding \"" + Excerpt(encoding) +
                         "\": expected \"sRGB\", \"linear\" or \"gamma x\", x from 0.01 to 100");
    const py::gil_scoped_release released;
    try {
        return std::make_shared<Image>(ReadImage(path, *parsed, {}));
    } catch (const SceneError& e) {
        // A reader of textures blames the scene; here it is the file that the user named.
        const std::string prefix = path + ": ";
        const std::string& message = e.Message();
        throw FileError(path, message.starts_with(prefix) ? message.substr(prefix.size()) : message);
    }
}

void Write(const Image& image, const std::string& path, bool half) {
    const py::gil_scoped_release released;
    WriteImage(image, path, half);
}

/// The image without its noise, and without the halves, which no denoiser can use again.
std::shared_ptr<Image> Denoise(const Image& image, const std::string& denoiser, const py::object& progress) {
    const RenderTurn mine;
    Notices notices;
    Image denoised = image;
    try {
        RunInterruptibly(notices, progress,
                         [&] { denoise::DenoiseImage(denoise::MethodOf(denoiser), &denoised, &notices); });
    } catch (const py::error_already_set&) {
        throw;
    } catch (const std::invalid_argument& e) {
        throw UsageError(std::string("the image ") + e.what());
    } catch (const std::runtime_error& e) {
        throw UsageError(std::string("the image cannot be denoised: ") + e.what());
    }
    return std::make_shared<Image>(AovBuffer::WithoutHalves(denoised));
}

/// Every name, with why this build does not have it; empty: it does.
std::vector<std::pair<std::string, std::string>> Denoisers() {
    std::vector<std::pair<std::string, std::string>> all;
    for (const std::string& name : denoise::MethodNames())
        all.emplace_back(name, denoise::WhyUnavailable(denoise::MethodOf(name)));
    return all;
}

}  // namespace

void DefineImages(py::module_& m) {
    py::class_<Image, std::shared_ptr<Image>>(m, "Image")
        .def(py::init(&ImageOf), py::arg("pixels"), py::arg("channels"), py::arg("metadata"))
        .def("array", &ArrayOf)
        .def("channels", &Image::Channels)
        .def("metadata", &MetadataOf)
        .def("write", &Write, py::arg("path"), py::arg("half"));
    m.def("denoise", &Denoise, py::arg("image"), py::arg("denoiser"), py::arg("progress"));
    m.def("denoisers", &Denoisers);
    m.def("read_image", &Read, py::arg("path"), py::arg("encoding"));
}

}  // namespace lacquer::python
