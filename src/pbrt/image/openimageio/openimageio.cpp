// OpenImageIO as an ImageLibrary: the module that programs load, and its files and filters. Nothing of
// Lacquer but headers is linked to it, so that there is one copy of everything in a program.
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>

#include "pbrt/image/image_library.h"
#include "pbrt/image/openimageio/tiles.h"
#include "pbrt/image/openimageio/value_type.h"

namespace lacquer::openimageio {

namespace {

// ---- Reading ----

MetadataValue Matrix(const OIIO::ParamValue& p) {
    glm::mat4 m;
    std::memcpy(&m, p.data(), sizeof m);
    return m;
}

/// Attributes of types that nobody asks for are left out.
void AddAttribute(const OIIO::ParamValue& p, ImageContents* contents) {
    const OIIO::TypeDesc type = p.type();
    const auto add = [&](MetadataValue value) {
        contents->attributes.emplace_back(p.name().string(), std::move(value));
    };
    if (type == OIIO::TypeInt) {
        add(*static_cast<const int*>(p.data()));
    } else if (type == OIIO::TypeUInt16 || type == OIIO::TypeUInt32) {
        add(p.get_int());  // what cameras write of themselves
    } else if (type == OIIO::TypeFloat) {
        add(*static_cast<const float*>(p.data()));
    } else if (type == OIIO::TypeString) {
        add(p.get_string());
    } else if (type == OIIO::TypeMatrix44) {
        add(Matrix(p));
    } else if (type.basetype == OIIO::TypeDesc::FLOAT) {
        const auto* values = static_cast<const float*>(p.data());
        add(std::vector<float>(values, values + type.numelements() * size_t(type.aggregate)));
    }
}

ImageContents ContentsOf(const OIIO::ImageSpec& spec) {
    ImageContents contents;
    contents.resolution = {spec.width, spec.height};
    contents.depth = spec.depth;
    contents.isDeep = spec.deep;
    contents.origin = {spec.x, spec.y};
    contents.fullOrigin = {spec.full_x, spec.full_y};
    contents.fullResolution = {spec.full_width, spec.full_height};
    contents.tileRows = spec.tile_width > 0 ? spec.tile_height : 0;
    contents.channels = spec.channelnames;
    contents.channels.resize(size_t(spec.nchannels));
    contents.type = ValueTypeOf(spec.format);
    for (const OIIO::TypeDesc& type : spec.channelformats) contents.channelTypes.push_back(ValueTypeOf(type));
    for (const OIIO::ParamValue& p : spec.extra_attribs) AddAttribute(p, &contents);
    return contents;
}

class Reader : public ImageReader {
  public:
    Reader(std::unique_ptr<OIIO::ImageInput> input, const std::string& path) : input_(std::move(input)) {
        OIIO::ImageSpec hints;
        hints["oiio:UnassociatedAlpha"] = 1;  // colours as they are in the file
        input_->threads(1);
        if (!input_->open(path, spec_, hints)) throw std::runtime_error(input_->geterror());
        contents_ = ContentsOf(spec_);
    }

    const ImageContents& Contents() const override { return contents_; }

    void Read(ValueType type, void* values) override {
        Check(input_->read_image(0, 0, 0, spec_.nchannels, TypeDescOf(type), values));
    }

    void ReadRows(int begin, int end, ValueType type, void* values) override {
        const int yBegin = spec_.y + begin, yEnd = spec_.y + end;
        const OIIO::TypeDesc desc = TypeDescOf(type);
        if (spec_.tile_width == 0)
            Check(input_->read_scanlines(0, 0, yBegin, yEnd, 0, 0, spec_.nchannels, desc, values));
        else
            Check(input_->read_tiles(0, 0, spec_.x, spec_.x + spec_.width, yBegin, yEnd, 0, 1, 0,
                                     spec_.nchannels, desc, values));
    }

  private:
    void Check(bool success) const {
        // Some readers report damage only by their message.
        if (!success || input_->has_error()) throw std::runtime_error(input_->geterror());
    }

    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;
    ImageContents contents_;
};

// ---- Writing ----

struct AddTo {
    OIIO::ImageSpec* spec;
    const std::string& name;
    void operator()(int value) const { spec->attribute(name, value); }
    void operator()(float value) const { spec->attribute(name, value); }
    void operator()(const std::string& value) const { spec->attribute(name, value); }
    // Columns in memory one after the other are the rows that the row-vector convention asks for.
    void operator()(const glm::mat4& value) const { spec->attribute(name, OIIO::TypeMatrix44, &value); }
    void operator()(const std::vector<float>& values) const {
        if (!values.empty())
            spec->attribute(name, OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, int(values.size())), values.data());
    }
};

OIIO::ImageSpec SpecOf(const ImageContents& contents) {
    OIIO::ImageSpec spec(contents.resolution.x, contents.resolution.y, int(contents.channels.size()),
                         TypeDescOf(contents.type));
    spec.channelnames = contents.channels;
    for (size_t i = 0; i < contents.channels.size(); ++i)
        if (contents.channels[i] == "A") spec.alpha_channel = int(i);
    for (const ValueType type : contents.channelTypes) spec.channelformats.push_back(TypeDescOf(type));
    spec.x = contents.origin.x;
    spec.y = contents.origin.y;
    if (contents.fullResolution.x > 0 && contents.fullResolution.y > 0) {
        spec.full_width = contents.fullResolution.x;
        spec.full_height = contents.fullResolution.y;
    }
    spec["compression"] = "zip";
    spec["oiio:UnassociatedAlpha"] = 1;
    for (const auto& [name, value] : contents.attributes) std::visit(AddTo{&spec, name}, value);
    spec["oiio:ColorSpace"] = contents.type == ValueType::UInt8 ? "sRGB" : "Linear";
    return spec;
}

std::unique_ptr<OIIO::ImageOutput> MakeOutput(const std::string& extension) {
    auto output = OIIO::ImageOutput::create(extension);
    if (!output) throw std::runtime_error(OIIO::geterror());
    return output;
}

class Library : public ImageLibrary {
  public:
    Library() {
        // OpenImageIO's own check against files that claim to be enormous; it is per process.
        OIIO::attribute("limits:imagesize_MB", int(kMaxImageBytes >> 20));
        OIIO::attribute("limits:channels", kMaxImageChannels);
    }

    std::unique_ptr<ImageReader> Open(const std::string& format, const std::string& path) const override {
        auto input = OIIO::ImageInput::create(format);
        if (!input) return nullptr;
        return std::make_unique<Reader>(std::move(input), path);
    }

    bool Writes(const std::string& format) const override {
        const std::string all = "," + std::string(OIIO::get_string_attribute("output_format_list")) + ",";
        return all.find("," + format + ",") != std::string::npos;
    }

    WriterLimits LimitsOf(const std::string& extension) const override {
        const auto output = MakeOutput(extension);
        return {output->supports("nchannels") != 0, output->supports("alpha") != 0};
    }

    std::vector<unsigned char> Encode(const ImageContents& contents, const void* values,
                                      const std::string& extension, const std::string& path) const override {
        const auto output = MakeOutput(extension);
        // In memory: on a full disk, some of the libraries report success and others end the process.
        OIIO::Filesystem::IOVecOutput memory;
        output->threads(1);
        const auto type = contents.type == ValueType::UInt8 ? OIIO::TypeDesc::UINT8 : OIIO::TypeDesc::FLOAT;
        bool success = output->set_ioproxy(&memory) && output->open(path, SpecOf(contents)) &&
                       output->write_image(type, values);
        success = output->close() && success;
        if (!success) throw std::runtime_error(output->geterror());
        return std::move(memory.buffer());
    }

    void Resize(const Pixels<const float>& from, const Pixels<float>& to, int channels,
                const std::string& filter) const override {
        const auto spec = [&](Int2 resolution) {
            return OIIO::ImageSpec(resolution.x, resolution.y, channels, OIIO::TypeFloat);
        };
        // It takes nothing that is const, and changes nothing of an ImageBuf that is.
        const OIIO::ImageBuf source(spec(from.resolution), const_cast<float*>(from.values));
        OIIO::ImageBuf target(spec(to.resolution), to.values);
        if (!OIIO::ImageBufAlgo::resize(target, source, filter, 0, {}, 1))
            throw std::runtime_error(target.geterror());
    }

    std::unique_ptr<TileStore> MakeTileStore() const override { return MakeTiles(); }
};

}  // namespace

}  // namespace lacquer::openimageio

const lacquer::ImageLibrary* LacquerOpenImageIO(int version) {
    if (version != lacquer::ImageLibrary::kVersion) return nullptr;
    static const lacquer::openimageio::Library library;
    return &library;
}
