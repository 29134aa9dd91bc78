// The grid of the coat tables: what the program that computes them and the functions that read them share.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace lacquer::layered {

/// File of the tables: 32-bit IEEE 754 floats, little-endian, no header; for the models Trowbridge-Reitz and
/// Beckmann in this order
///     entry    [kAlpha][kEta][kCos][1 + kEntryPaths]  t at optical thickness 0, and the mean paths m below
///     back     [kAlpha][kEta][2 + kReturnPaths]       R at optical thickness 0, m, and the share of walks
///                                                     that comes back (CoatReturn::probabilityBack)
///     density  [kAlpha][kEta][2][kCos]                CoatEntry::probabilityIn, densityOut
/// An optical thickness tau is attenuated as t = t(0) exp(-tau m(tau)): m varies far less than t does, being
/// the mean of 1/cos at tau = 0 and its smallest value at infinity. Its nodes are equally spaced in
/// log(1 + tau/kEntryTauScale) for light from outside, in sqrt(tau/(1 + tau)) for that from below, whose
/// paths have a heavy tail; up to kLargestEntryTau or kLargestReturnTau, from where on m is constant.
struct CoatGrid {
    static constexpr int kModels = 2;
    static constexpr int kAlpha = 32, kEta = 16, kCos = 48;
    static constexpr int kEntryPaths = 7, kReturnPaths = 14;
    static constexpr int kEntryChannels = 1 + kEntryPaths, kReturnChannels = 2 + kReturnPaths;
    static constexpr int kDensityChannels = 2;
    static constexpr float kLargestEntryTau = 6, kLargestReturnTau = 4;
    static constexpr float kMinEta = 1.05f, kMaxEta = 2.5f;

    static constexpr size_t kEntryFloats = size_t(kAlpha) * kEta * kCos * kEntryChannels;
    static constexpr size_t kReturnFloats = size_t(kAlpha) * kEta * kReturnChannels;
    static constexpr size_t kDensityFloats = size_t(kAlpha) * kEta * kCos * kDensityChannels;
    static constexpr size_t kModelFloats = kEntryFloats + kReturnFloats + kDensityFloats;

    // Coordinates in [0,1] along which nodes are equally spaced, and their inverses. Functions of cos and
    // alpha change where the two are alike, however small: hence the fourth roots. Near vertical incidence
    // some have terms of the third power of the angle: hence the second root for cosines.
    static float AlphaCoordinate(float alpha) { return std::sqrt(std::sqrt(alpha)); }
    static double AlphaAt(double x) { return x * x * x * x; }
    static float CosCoordinate(float c) {
        constexpr float kScale = 1.20948977f;  // 1/(1 - sqrt(1 - kCosBend))
        return (1 - std::sqrt(1 - float(kCosBend) * std::sqrt(std::sqrt(std::min(c, 1.f))))) * kScale;
    }
    static double CosAt(double x) {
        const double root = 1 - x * (1 - std::sqrt(1 - kCosBend));
        const double fourth = (1 - root * root) / kCosBend;
        return fourth * fourth * fourth * fourth;
    }
    static float EtaCoordinate(float eta) {
        constexpr float kScale = 0.32488942f;  // 1/log((kMaxEta - kEtaShift)/(kMinEta - kEtaShift))
        return std::log((eta - float(kEtaShift)) * 14.2857143f) * kScale;
    }
    static double EtaAt(double x) { return kEtaShift + 0.07 * std::pow(1.52 / 0.07, x); }
    static float EntryTauCoordinate(float tau) {
        constexpr float kScale = 0.18856166f;  // 1/log(1 + kLargestEntryTau / kEntryTauScale)
        return std::log(1 + std::min(tau, kLargestEntryTau) * float(1 / kEntryTauScale)) * kScale;
    }
    static double EntryTauAt(double x) {
        return kEntryTauScale * (std::pow(1 + double(kLargestEntryTau) / kEntryTauScale, x) - 1);
    }
    static float ReturnTauCoordinate(float tau) {
        constexpr float kScale = 1.1180340f;  // sqrt((1 + kLargestReturnTau) / kLargestReturnTau)
        const float limited = std::min(tau, kLargestReturnTau);
        return std::min(std::sqrt(limited / (1 + limited)) * kScale, 1.f);
    }
    static double ReturnTauAt(double x) {
        const double square = x * x * double(kLargestReturnTau) / (1 + double(kLargestReturnTau));
        return square / (1 - square);
    }

  private:
    static constexpr double kEntryTauScale = 0.03;
    static constexpr double kEtaShift = 0.98;
    static constexpr double kCosBend = 0.97;
};

}  // namespace lacquer::layered
