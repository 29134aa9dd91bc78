#include "cmd/render/merge_states.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "cmd/command_support.h"
#include "cmd/render/film_record.h"
#include "cmd/render/state_header.h"
#include "cmd/version.h"
#include "pbrt/core/file_lock.h"
#include "pbrt/film/state_file.h"
#include "pbrt/image/image.h"
#include "pbrt/integrators/rendered_image.h"

namespace lacquer::cmd {
namespace {

namespace fs = std::filesystem;

bool IsStateName(const std::string& path) { return ExtensionOf(path) == "state"; }

class StateMergeJob {
  public:
    StateMergeJob(const StateMerge& merge, Console* console) : m_(merge), console_(console) {}

    ExitStatus Run() {
        CheckOutput();
        for (const std::string& path : m_.states)
            headers_.push_back(StateHeader::Read(path, ReadStateHeader(path)));
        RefuseCropsOfShares();
        for (size_t i = 1; i < headers_.size(); ++i) CheckSameRender(i);
        RefuseCropsOfSplats();
        MakeFilm();
        CheckSamples();
        for (size_t i = 0; i < headers_.size(); ++i) Add(i);
        Write();
        return ExitStatus::Complete;
    }

  private:
    void CheckOutput() {
        if (IsStateName(m_.outfile)) {
            CheckOutputFile(m_.outfile);
            lock_.emplace(m_.outfile);
        } else {
            CheckImageOutput(m_.outfile);
        }
        for (const std::string& path : m_.states) {
            std::error_code error;
            if (fs::equivalent(path, m_.outfile, error))
                throw CLI::ValidationError(
                    fmt::format("--outfile: {} is one of the states that are merged", m_.outfile));
        }
    }

    [[noreturn]] void Refuse(size_t i, const std::string& why) const {
        throw FileError(m_.states[i], fmt::format("cannot be merged with {}: {}", m_.states[0], why));
    }

    void CheckSameRender(size_t i) const {
        std::string why = Difference(headers_[0], headers_[i]);
        if (why.empty() && headers_[0].filterSamples != headers_[i].filterSamples)
            why = fmt::format(
                "its textures are filtered for {} samples per pixel, and not for {}; render all "
                "parts with the same --spp",
                headers_[i].filterSamples, headers_[0].filterSamples);
        if (why.empty() && headers_[0].halfBlock != headers_[i].halfBlock)
            why = "the halves of its samples are others; render all parts with the same --spp";
        if (!why.empty()) Refuse(i, "it is the state of another render: " + why);
    }

    /// Adaptive sampling divides the samples among the pixels that it renders.
    void RefuseCropsOfShares() const {
        const auto isAdaptive = [](const StateHeader& header) {
            return header.settings.contains("adaptive") && header.settings["adaptive"].is_string();
        };
        for (size_t i = 1; i < headers_.size(); ++i)
            if (isAdaptive(headers_[0]) && isAdaptive(headers_[i]) &&
                headers_[i].pixels != headers_[0].pixels)
                Refuse(
                    i,
                    "adaptive sampling has divided the samples of each crop by itself; divide such a render "
                    "by --sample-range");
    }

    /// A state has the splats on its own pixels alone, and every sample of a crop makes some on others.
    void RefuseCropsOfSplats() const {
        if (!MakesSplats(headers_[0].film)) return;
        for (size_t i = 1; i < headers_.size(); ++i)
            if (headers_[i].pixels != headers_[0].pixels)
                Refuse(i,
                       "light that is traced from the lights by the samples of one crop lands on the "
                       "pixels of others, and their states do not have it; divide such a render by "
                       "--sample-range");
    }

    void MakeFilm() {
        FilmOverrides overrides;
        // Films of more than colours refuse other images by this name.
        overrides.filename = IsStateName(m_.outfile) ? "merged.exr" : m_.outfile;
        overrides.pixelBounds = m_.pixelBounds;
        // What splats have missed is no part of another state.
        if (MakesSplats(headers_[0].film)) overrides.pixelBounds = headers_[0].pixels;
        try {
            restored_ = RestoreFilm(headers_[0].film, overrides);
        } catch (const nlohmann::json::exception&) {
            throw FileError(m_.states[0], "is no state of a render that this program can read");
        }
        const bool hasOutputs = restored_.aovs || restored_.hasPasses;
        if (hasOutputs && !IsStateName(m_.outfile) && ExtensionOf(m_.outfile) != "exr")
            throw CLI::ValidationError(fmt::format(
                "--outfile: the outputs of these states need an EXR file for their channels; \"{}\" holds "
                "colours only",
                m_.outfile));
    }

    void CheckSamples() {
        const Bounds2i whole = restored_.film->PixelBounds();
        for (size_t i = 0; i < headers_.size(); ++i) {
            if (headers_[i].pixels.Intersect(whole) != headers_[i].pixels)
                throw FileError(m_.states[i],
                                fmt::format("has the pixels {}, and {} are expected",
                                            PixelsInWords(headers_[i].pixels), PixelsInWords(whole)));
            samples_ = std::max(samples_, headers_[i].samplesPerPixel);
            for (size_t j = 0; j < i; ++j) CheckNothingIsDouble(j, i, whole);
        }
        for (const StateHeader& header : headers_)
            for (const StatePart& part : header.parts) AddPart(part, &parts_);
        missing_ = MissingSamples(parts_, {whole, 0, samples_});
        if (missing_.empty()) return;
        const std::string what = SamplesInWords(missing_, whole);
        // States of a tree of merges lack what other branches have.
        if (!m_.isPartial && !IsStateName(m_.outfile))
            throw FileError(m_.outfile, fmt::format("is not written: {} are missing; with --partial, what is "
                                                    "there is taken",
                                                    what));
        if (m_.isPartial && !IsStateName(m_.outfile)) console_->Warn(what + " are missing");
    }

    void CheckNothingIsDouble(size_t j, size_t i, const Bounds2i& whole) const {
        for (const StatePart& a : headers_[j].parts)
            for (const StatePart& b : headers_[i].parts)
                if (const SampleBox shared = SharedSamples(a, b); !shared.IsEmpty())
                    throw FileError(m_.states[i], fmt::format("has {}, as {} has",
                                                              SamplesInWords(shared, whole), m_.states[j]));
    }

    void Add(size_t i) {
        const StateFile file = ReadStateFile(m_.states[i]);
        const std::string why =
            AddState(file.arrays, restored_.State(), headers_[i].pixels, restored_.film->PixelBounds());
        if (!why.empty()) Refuse(i, why);
        seconds_ += headers_[i].seconds;
    }

    void Write() {
        if (IsStateName(m_.outfile))
            WriteState();
        else
            WriteImage();
        console_->Info(fmt::format("{}: {} {}{}", m_.outfile, headers_.size(),
                                   headers_.size() == 1 ? "state" : "states",
                                   missing_.empty() ? "; nothing is missing" : ""));
    }

    void WriteState() {
        StateHeader header = headers_[0];
        header.pixels = restored_.film->PixelBounds();
        header.parts = parts_;
        header.seconds = seconds_;
        for (const StateHeader& other : headers_)
            header.samplesPerPixel = std::max(header.samplesPerPixel, other.samplesPerPixel);
        WriteStateFile(m_.outfile, header.Text(), restored_.State());
    }

    void WriteImage() {
        const std::vector<int> counts = restored_.film->SampleCounts();
        const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
        ImageOrigin origin;
        origin.samplesPerPixel = missing_.empty() ? samples_ : *least;
        origin.firstSample = std::min_element(parts_.begin(), parts_.end(), [](const auto& a, const auto& b) {
                                 return a.first < b.first;
                             })->first;
        origin.seconds = seconds_;
        origin.showsSampleCounts = *least != *most && ExtensionOf(m_.outfile) == "exr";
        origin.software = fmt::format("Lacquer {}", kVersion);
        origin.scene = headers_[0].name;
        const std::unique_ptr<Image> image = DevelopFilm(*restored_.film, restored_.aovs.get(),
                                                         restored_.hasPasses, restored_.metadata, origin);
        lacquer::WriteImage(*image, m_.outfile, restored_.film->SavesHalf());
    }

    const StateMerge& m_;
    Console* console_;
    std::optional<FileLock> lock_;
    std::vector<StateHeader> headers_;
    RestoredFilm restored_;
    std::vector<StatePart> parts_;
    std::vector<SampleBox> missing_;
    int samples_ = 0;  ///< of a pixel, of the whole
    double seconds_ = 0;
};

}  // namespace

ExitStatus MergeStates(const StateMerge& merge, Console* console) {
    return StateMergeJob(merge, console).Run();
}

}  // namespace lacquer::cmd
