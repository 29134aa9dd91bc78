#include "measure/bsdf_tables.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "measure/color_mean.h"
#include "measure/half_difference.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"

namespace lacquer::measure {

namespace {

// ---- Half and difference angles
// ----------------------------------------------------------------------------

/// Of the middle of a cell. The half vector lies over the x axis: isotropic materials do not mind.
DirectionPair PairOfCell(int half, int difference, int azimuth) {
    return PairOfAngles(
        {Sqr((half + 0.5) / MerlTable::kHalf) * kPi / 2, 0},
        {(difference + 0.5) / MerlTable::kDifference * kPi / 2, (azimuth + 0.5) / MerlTable::kAzimuth * kPi});
}

/// Of the database's files: what is stored is multiplied with these.
constexpr double kMerlScale[] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

void AppendBytes(const void* begin, size_t size, std::string* bytes) {
    bytes->append(static_cast<const char*>(begin), size);
}

// ---- Klems's patches
// ---------------------------------------------------------------------------------------

/// Rings of the full basis: numbers of patches, and upper bounds [degrees].
constexpr int kRings = 9;
constexpr int kRingPatches[kRings] = {1, 8, 16, 20, 24, 24, 24, 16, 12};
constexpr double kRingEnds[kRings] = {5, 15, 25, 35, 45, 55, 65, 75, 90};

struct Patch {
    double sin2Begin, sin2End;  ///< of the ring
    double phi, halfWidth;      ///< of its middle [radians]
};
Patch PatchAt(int number) {
    double begin = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        const double end = Sqr(std::sin(kRingEnds[ring] * kPi / 180)), width = 2 * kPi / kRingPatches[ring];
        if (number < kRingPatches[ring]) return {begin, end, number * width, width / 2};
        number -= kRingPatches[ring];
        begin = end;
    }
    return {begin, begin, 0, 0};
}
/// @param w  on the hemisphere z > 0
int PatchOf(Vec3 w) {
    const double sin2 = double(w.x) * double(w.x) + double(w.y) * double(w.y);
    double phi = std::atan2(double(w.y), double(w.x));
    if (phi < 0) phi += 2 * kPi;
    int first = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        const int count = kRingPatches[ring];
        if (sin2 <= Sqr(std::sin(kRingEnds[ring] * kPi / 180)) || ring == kRings - 1)
            return first + int(phi / (2 * kPi) * count + 0.5) % count;
        first += count;
    }
    return first;
}
/// A direction in a patch, by projected solid angle. @param u  in [0,1)^2
Vec3 InPatch(const Patch& p, Point2 u) {
    const double sin2 = p.sin2Begin + double(u.x) * (p.sin2End - p.sin2Begin);
    const double phi = p.phi + (2 * double(u.y) - 1) * p.halfWidth;
    return DirectionAt({std::asin(std::sqrt(sin2)), phi});
}

/// Energies that light from one patch brings to all patches.
struct PatchEnergies {
    std::vector<double> reflected = std::vector<double>(KlemsTable::kPatches);
    std::vector<double> transmitted = std::vector<double>(KlemsTable::kPatches);
};
PatchEnergies EnergiesFrom(const BsdfSubject& subject, int patch, bool isFront, const TableOptions& options) {
    PatchEnergies energies;
    const Patch from = PatchAt(patch);
    Rng rng(Hash(options.seed, patch, int(isFront)));
    const int64_t draws =
        int64_t(std::max(1, options.samples)) * 64 * subject.NumVariants() * BsdfSubject::kNumSets;
    for (int64_t i = 0; i < draws; ++i) {
        Vec3 wi = InPatch(from, rng.Uniform2D());
        if (!isFront) wi.z = -wi.z;
        const BxDFRandom u{rng.Uniform(), rng.Uniform2D()};
        const auto s = subject.At(i).Sample(wi, u, {.mode = TransportMode::Importance, .rng = &rng});
        if (!s || !s->weight.IsValid() || s->wi.z == 0) continue;
        const bool isReflected = SameHemisphere(wi, s->wi);
        const double energy = Luminance(glm::dvec3(subject.ToRGB(s->weight, i))) / double(draws);
        (isReflected ? energies.reflected
                     : energies.transmitted)[size_t(PatchOf({s->wi.x, s->wi.y, std::abs(s->wi.z)}))] +=
            energy;
    }
    return energies;
}

std::string Block(const char* direction, const char* type, const std::vector<double>& values) {
    std::string text = fmt::format(
        "<WavelengthData>\n<LayerNumber>System</LayerNumber>\n<Wavelength "
        "unit=\"Integral\">Visible</Wavelength>\n"
        "<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>\n<DetectorSpectrum>ASTM E308 1931 "
        "Y.dsp</DetectorSpectrum>\n"
        "<WavelengthDataBlock>\n<WavelengthDataDirection>{}</WavelengthDataDirection>\n"
        "<ColumnAngleBasis>LBNL/Klems Full</ColumnAngleBasis>\n<RowAngleBasis>LBNL/Klems "
        "Full</RowAngleBasis>\n"
        "<ScatteringDataType>{}</ScatteringDataType>\n<ScatteringData>\n",
        direction, type);
    for (int row = 0; row < KlemsTable::kPatches; ++row) {
        for (int column = 0; column < KlemsTable::kPatches; ++column)
            text += fmt::format("{:.6g}, ", values[size_t(row * KlemsTable::kPatches + column)]);
        text += "\n";
    }
    return text + "</ScatteringData>\n</WavelengthDataBlock>\n</WavelengthData>\n";
}

std::string Escaped(const std::string& text) {
    std::string escaped;
    for (const char c : text)
        escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
    return escaped;
}

}  // namespace

Lobes LobesFromAbove(const BsdfSubject& subject, uint64_t seed) {
    Rng rng(Hash(seed, 8));
    Lobes lobes = Lobes::None;
    for (int64_t i = 0; i < 4096; ++i) {
        const Vec3 wo = SampleCosineHemisphere(rng.Uniform2D());
        const BxDFRandom u{rng.Uniform(), rng.Uniform2D()};
        if (const auto s = subject.At(i).Sample(wo, u, {.rng = &rng})) lobes = lobes | s->lobe;
    }
    return lobes;
}

MerlTable TabulateMerl(const BsdfSubject& subject, const TableOptions& options, Observer* observer) {
    MerlTable table;
    const size_t cells = size_t(MerlTable::kHalf) * MerlTable::kDifference * MerlTable::kAzimuth;
    table.values.assign(3 * cells, -1);
    const int64_t batches = subject.IsStochastic() ? std::max(1, options.samples) : subject.NumVariants();
    if (observer) observer->Begin("Tabulating", MerlTable::kHalf, "");
    ParallelFor(int64_t(MerlTable::kHalf), [&](int64_t half) {
        Rng rng(Hash(options.seed, half));
        for (int difference = 0; difference < MerlTable::kDifference; ++difference)
            for (int azimuth = 0; azimuth < MerlTable::kAzimuth; ++azimuth) {
                const DirectionPair pair = PairOfCell(int(half), difference, azimuth);
                if (!(pair.wo.z > 0) || !(pair.wi.z > 0)) continue;
                const glm::dvec3 f =
                    subject.Evaluate(pair.wo, pair.wi, TransportMode::Radiance, batches, rng).Mean();
                const size_t cell =
                    (size_t(half) * MerlTable::kDifference + size_t(difference)) * MerlTable::kAzimuth +
                    size_t(azimuth);
                for (int c = 0; c < 3; ++c) table.values[size_t(c) * cells + cell] = std::max(0.0, f[c]);
            }
        if (observer) observer->Advance(1);
    });
    if (observer) observer->End();
    return table;
}

std::string MerlTable::Bytes() const {
    std::string bytes;
    const int32_t sizes[] = {kHalf, kDifference, kAzimuth};
    AppendBytes(sizes, sizeof(sizes), &bytes);
    const size_t cells = values.size() / 3;
    for (size_t i = 0; i < values.size(); ++i) {
        const double stored = values[i] < 0 ? -1 : values[i] / kMerlScale[i / cells];
        AppendBytes(&stored, sizeof(stored), &bytes);
    }
    return bytes;
}

double KlemsTable::SolidAngleOf(int patch) {
    const Patch p = PatchAt(patch);
    return (p.sin2End - p.sin2Begin) * p.halfWidth;
}

KlemsTable TabulateKlems(const BsdfSubject& subject, const TableOptions& options, Observer* observer) {
    constexpr auto kCount = size_t(KlemsTable::kPatches);
    KlemsTable table;
    for (std::vector<double>* values :
         {&table.frontReflection, &table.frontTransmission, &table.backReflection, &table.backTransmission})
        values->assign(kCount * kCount, 0);
    if (observer) observer->Begin("Tabulating", 2 * int64_t(kCount), "");
    ParallelFor(2 * int64_t(kCount), [&](int64_t job) {
        const bool isFront = job < int64_t(kCount);
        const auto incoming = size_t(job) % kCount;
        const PatchEnergies energies = EnergiesFrom(subject, int(incoming), isFront, options);
        for (size_t outgoing = 0; outgoing < kCount; ++outgoing) {
            const double area = KlemsTable::SolidAngleOf(int(outgoing));
            const size_t at = outgoing * kCount + incoming;
            (isFront ? table.frontReflection : table.backReflection)[at] =
                energies.reflected[outgoing] / area;
            (isFront ? table.frontTransmission : table.backTransmission)[at] =
                energies.transmitted[outgoing] / area;
        }
        if (observer) observer->Advance(1);
    });
    if (observer) observer->End();
    return table;
}

std::string KlemsTable::Xml(const std::string& name) const {
    std::string text = fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<WindowElement xmlns=\"http://windows.lbl.gov\">\n"
        "<WindowElementType>System</WindowElementType>\n<Optical>\n<Layer>\n<Material>\n<Name>{}</Name>\n"
        "<Manufacturer>Lacquer</Manufacturer>\n<DeviceType>Other</DeviceType>\n</Material>\n"
        "<DataDefinition>\n<IncidentDataStructure>Columns</IncidentDataStructure>\n<AngleBasis>\n"
        "<AngleBasisName>LBNL/Klems Full</AngleBasisName>\n",
        Escaped(name));
    double begin = 0;
    for (int ring = 0; ring < kRings; ++ring) {
        const double end = kRingEnds[ring], middle = ring == 0 ? 0 : (begin + end) / 2;
        text += fmt::format(
            "<AngleBasisBlock>\n<Theta>{:g}</Theta>\n<nPhis>{}</nPhis>\n<ThetaBounds>\n<LowerTheta>{:g}</"
            "LowerTheta>\n"
            "<UpperTheta>{:g}</UpperTheta>\n</ThetaBounds>\n</AngleBasisBlock>\n",
            middle, kRingPatches[ring], begin, end);
        begin = end;
    }
    text += "</AngleBasis>\n</DataDefinition>\n";
    text += Block("Transmission Front", "BTDF", frontTransmission) +
            Block("Transmission Back", "BTDF", backTransmission) +
            Block("Reflection Front", "BRDF", frontReflection) +
            Block("Reflection Back", "BRDF", backReflection);
    return text + "</Layer>\n</Optical>\n</WindowElement>\n";
}

}  // namespace lacquer::measure
