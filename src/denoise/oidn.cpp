#include "denoise/oidn.h"

#include <stdexcept>
#include <string>

#if LACQUER_HAS_OIDN
#include <OpenImageDenoise/oidn.hpp>
#endif

namespace lacquer::denoise {

namespace {

#if LACQUER_HAS_OIDN

/// Also of devices that could not be made: for those the library keeps the reason, too.
void Check(oidn::DeviceRef& device) {
    const char* message = nullptr;
    if (device.getError(message) == oidn::Error::None) return;
    throw std::runtime_error(std::string("Open Image Denoise: ") +
                             (message && *message ? message : "failed without a reason"));
}

/// On processors, whatever else there is: the library then takes memory of ours as it is, in version 1 as
/// in 2.
oidn::DeviceRef MakeDevice(int threads) {
    oidn::DeviceRef device = oidn::newDevice(oidn::DeviceType::CPU);
    Check(device);
    if (!device) throw std::runtime_error("Open Image Denoise: there is no device for processors");
    device.set("numThreads", threads);
    device.commit();
    Check(device);
    return device;
}

/// One filter of all that run, as part of the whole work.
class Progress {
  public:
    Progress(int64_t units, Observer* observer) : units_(units), observer_(observer) {}
    /// What the library calls; true: go on.
    static bool Tell(void* self, double fraction) {
        static_cast<Progress*>(self)->Reach(fraction);
        return true;
    }
    void Reach(double fraction) {
        const auto reached = int64_t(fraction * double(units_));
        if (!observer_ || reached <= done_) return;
        observer_->Advance(reached - done_);
        done_ = reached;
    }

  private:
    int64_t units_, done_ = 0;
    Observer* observer_;
};

class Filter {
  public:
    explicit Filter(oidn::DeviceRef& device) : device_(device), filter_(device.newFilter("RT")) {
        Check(device_);
    }
    /// Rows of packed floats. The library's inputs are not const, but are only read.
    Filter& Read(const char* name, const Color& image) { return Write(name, const_cast<Color*>(&image)); }
    Filter& Write(const char* name, Color* image) {
        const Int2 size = image->Size();
        filter_.setImage(name, image->All().data(), oidn::Format::Float3, size_t(size.x), size_t(size.y));
        return *this;
    }
    Filter& Set(const char* name) {
        filter_.set(name, true);
        return *this;
    }
    void Run(Observer* observer, int64_t units) {
        Progress progress(units, observer);
        if (observer) filter_.setProgressMonitorFunction(Progress::Tell, &progress);
        filter_.commit();
        Check(device_);
        filter_.execute();
        Check(device_);
        progress.Reach(1);
    }

  private:
    oidn::DeviceRef& device_;
    oidn::FilterRef filter_;
};

Color Filtered(const Color& color, const Color& albedo, const Color& normal, int threads,
               Observer* observer) {
    const Int2 size = color.Size();
    const int64_t pixels = int64_t(size.x) * size.y;
    oidn::DeviceRef device = MakeDevice(threads);
    Color cleanAlbedo(size), cleanNormal(size), result(size);
    if (observer) observer->Begin("denoising", 3 * pixels, "pixels");
    Filter(device).Read("albedo", albedo).Write("output", &cleanAlbedo).Run(observer, pixels);
    Filter(device).Read("normal", normal).Write("output", &cleanNormal).Run(observer, pixels);
    Filter(device)
        .Read("color", color)
        .Read("albedo", cleanAlbedo)
        .Read("normal", cleanNormal)
        .Write("output", &result)
        .Set("hdr")
        .Set("cleanAux")
        .Run(observer, pixels);
    if (observer) observer->End();
    return result;
}

#else

Color Filtered(const Color&, const Color&, const Color&, int, Observer*) {
    throw std::runtime_error("Open Image Denoise was not built in");
}

#endif

}  // namespace

bool HasOidn() { return LACQUER_HAS_OIDN != 0; }

Color FilterByOidn(const Color& color, const Color& albedo, const Color& normal, int threads,
                   Observer* observer) {
    return Filtered(color, albedo, normal, threads, observer);
}

}  // namespace lacquer::denoise
