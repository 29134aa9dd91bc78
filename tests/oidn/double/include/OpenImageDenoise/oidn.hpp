// A test double of Intel Open Image Denoise: of its C++ interface what src/denoise/oidn.cpp calls, by the
// documented contract (commit before use, required images, strides, errors kept by the device, also without
// one). It filters nothing: what it computes shows which pixels have arrived as what.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace oidn {

enum class DeviceType { Default, CPU, SYCL, CUDA, HIP };
enum class Format { Undefined = 0, Float = 1, Float2, Float3, Float4 };
enum class Error {
    None,
    Unknown,
    InvalidArgument,
    InvalidOperation,
    OutOfMemory,
    UnsupportedHardware,
    Cancelled
};
typedef bool (*ProgressMonitorFunction)(void* userPtr, double n);

struct ImageParameter {
    const std::byte* data = nullptr;
    Format format = Format::Undefined;
    size_t width = 0, height = 0, pixelStride = 0, rowStride = 0;
    const float* Pixel(size_t x, size_t y) const {
        return reinterpret_cast<const float*>(data + y * rowStride + x * pixelStride);
    }
};

/// What an executed filter was given.
struct Execution {
    std::map<std::string, ImageParameter> images;
    std::map<std::string, bool> flags;
};

/// What tests look at and steer.
struct State {
    std::string failAt;  ///< "newDevice", "commitDevice", "newFilter", "commitFilter", "execute"
    std::string message = "the reason";
    bool hasNoDevice = false;  ///< newDevice() gives nothing, and no reason
    std::vector<Execution> executions;
    DeviceType type = DeviceType::Default;
    int numThreads = 0, alive = 0;
    std::pair<Error, std::string> withoutDevice{Error::None, ""};
};
inline State state;

class Handle {
  public:
    Handle() { ++state.alive; }
    ~Handle() { --state.alive; }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
};

struct DeviceData : Handle {
    bool isCommitted = false;
    std::pair<Error, std::string> error{Error::None, ""};
    /// The first that nobody has asked for stays.
    void Fail(Error code, const std::string& message) {
        if (error.first == Error::None) error = {code, message};
    }
    bool FailsAt(const char* where) {
        if (state.failAt == where) Fail(Error::OutOfMemory, state.message);
        return error.first != Error::None;
    }
};

struct FilterData : Handle {
    std::shared_ptr<DeviceData> device;
    Execution given;
    bool isCommitted = false;
    ProgressMonitorFunction progress = nullptr;
    void* progressData = nullptr;
};

class FilterRef {
  public:
    FilterRef() = default;
    explicit FilterRef(std::shared_ptr<FilterData> data) : data_(std::move(data)) {}
    explicit operator bool() const { return data_ != nullptr; }

    void setImage(const char* name, void* pointer, Format format, size_t width, size_t height,
                  size_t byteOffset = 0, size_t pixelStride = 0, size_t rowStride = 0) {
        if (!data_) return;
        ImageParameter image{static_cast<std::byte*>(pointer) + byteOffset, format, width, height, pixelStride,
                             rowStride};
        if (image.pixelStride == 0) image.pixelStride = 3 * sizeof(float);
        if (image.rowStride == 0) image.rowStride = width * image.pixelStride;
        data_->given.images[name] = image;
        data_->isCommitted = false;
    }
    void set(const char* name, bool value) {
        if (!data_) return;
        data_->given.flags[name] = value;
        data_->isCommitted = false;
    }
    void setProgressMonitorFunction(ProgressMonitorFunction function, void* userPtr = nullptr) {
        if (!data_) return;
        data_->progress = function;
        data_->progressData = userPtr;
    }

    void commit() {
        if (!data_ || data_->device->FailsAt("commitFilter")) return;
        if (const char* problem = Problem())
            data_->device->Fail(Error::InvalidOperation, problem);
        else
            data_->isCommitted = true;
    }
    void execute() {
        if (!data_ || data_->device->FailsAt("execute")) return;
        if (!data_->isCommitted) {
            data_->device->Fail(Error::InvalidOperation, "changes to the filter are not committed");
            return;
        }
        for (const double n : {0.0, 0.5, 1.0})
            if (data_->progress && !data_->progress(data_->progressData, n)) {
                data_->device->Fail(Error::Cancelled, "cancelled");
                return;
            }
        Compute();
        state.executions.push_back(data_->given);
    }

  private:
    const ImageParameter* Find(const char* name) const {
        const auto found = data_->given.images.find(name);
        return found == data_->given.images.end() ? nullptr : &found->second;
    }
    const char* Problem() const {
        const ImageParameter* output = Find("output");
        if (!output) return "output image not specified";
        const bool color = Find("color"), albedo = Find("albedo"), normal = Find("normal");
        if (!color && !albedo && !normal) return "input image not specified";
        if (color && normal && !albedo) return "normal without albedo";
        if (!color && albedo && normal) return "two guides to filter at once";
        for (const auto& [name, image] : data_->given.images) {
            if (name != "output" && name != "color" && name != "albedo" && name != "normal")
                return "unknown image";
            if (!image.data) return "image without data";
            if (image.format != Format::Float3) return "unsupported format";
            if (image.width != output->width || image.height != output->height) return "sizes differ";
        }
        for (const auto& [name, value] : data_->given.flags) {
            if (name != "hdr" && name != "cleanAux" && name != "srgb") return "unknown parameter";
            if (value && !color) return "a parameter of colours without colours";
        }
        return nullptr;
    }
    /// Guides alone: half of them. Colours: twice as much, plus the albedo, plus ten times the normal.
    void Compute() const {
        const ImageParameter *color = Find("color"), *albedo = Find("albedo"), *normal = Find("normal"),
                             *output = Find("output");
        for (size_t y = 0; y < output->height; ++y)
            for (size_t x = 0; x < output->width; ++x)
                for (size_t c = 0; c < 3; ++c) {
                    float value = 0;
                    if (!color) value = 0.5f * (albedo ? albedo : normal)->Pixel(x, y)[c];
                    if (color) value += 2 * color->Pixel(x, y)[c];
                    if (color && albedo) value += albedo->Pixel(x, y)[c];
                    if (color && normal) value += 10 * normal->Pixel(x, y)[c];
                    const_cast<float*>(output->Pixel(x, y))[c] = value;
                }
    }

    std::shared_ptr<FilterData> data_;
};

class DeviceRef {
  public:
    DeviceRef() = default;
    explicit DeviceRef(std::shared_ptr<DeviceData> data) : data_(std::move(data)) {}
    explicit operator bool() const { return data_ != nullptr; }
    void set(const char* name, int value) {
        if (data_ && std::string(name) == "numThreads") state.numThreads = value;
        if (data_) data_->isCommitted = false;
    }
    void commit() {
        if (data_ && !data_->FailsAt("commitDevice")) data_->isCommitted = true;
    }
    /// Gives the first error, and forgets it; of a device that could not be made, too.
    Error getError(const char*& message) {
        auto& error = data_ ? data_->error : state.withoutDevice;
        static std::string text;  // which is valid until the next call
        text = error.second;
        message = text.c_str();
        return std::exchange(error, {Error::None, ""}).first;
    }
    FilterRef newFilter(const char* type) const {
        if (!data_ || data_->FailsAt("newFilter")) return {};
        if (!data_->isCommitted || std::string(type) != "RT") {
            data_->Fail(Error::InvalidOperation, data_->isCommitted ? "unknown type of filter"
                                                                    : "changes to the device are not committed");
            return {};
        }
        auto filter = std::make_shared<FilterData>();
        filter->device = data_;
        return FilterRef(std::move(filter));
    }

  private:
    std::shared_ptr<DeviceData> data_;
};

inline DeviceRef newDevice(DeviceType type = DeviceType::Default) {
    state.type = type;
    if (state.failAt == "newDevice") state.withoutDevice = {Error::UnsupportedHardware, state.message};
    if (state.failAt == "newDevice" || state.hasNoDevice) return {};
    return DeviceRef(std::make_shared<DeviceData>());
}

}  // namespace oidn
