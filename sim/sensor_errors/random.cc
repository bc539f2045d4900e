#include "sim/sensor_errors/random.h"

#include <array>
#include <bit>
#include <cmath>

namespace sim::sensor_errors {
namespace {

// The finalizer of splitmix64 (Steele, Lea & Flood 2014): a bijection of 64 bits without patterns.
std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ull;  // 2^64 / golden ratio, odd

std::uint64_t fnv1a(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ull;
  return hash;
}

// Natural logarithm by the series of 2 artanh((m - 1) / (m + 1)), m in [√½, √2). It gives the same bits on
// every machine, unlike the C library's. x > 0 and normal.
double fixed_log(double x) {
  const auto word = std::bit_cast<std::uint64_t>(x);
  int exponent = int(word >> 52) - 1023;
  double m = std::bit_cast<double>((word & 0xfffffffffffffull) | (1023ull << 52));
  if (m > 1.4142135623730951) m /= 2, ++exponent;
  const double s = (m - 1) / (m + 1), s2 = s * s;
  double sum = 0;
  for (int k = 23; k >= 1; k -= 2) sum = sum * s2 + 1.0 / k;
  return 2 * s * sum + exponent * 0.6931471805599453;
}

template <std::size_t N>
double polynomial(const std::array<double, N>& c, double x) {
  double sum = 0;
  for (std::size_t i = N; i-- > 0;) sum = sum * x + c[i];
  return sum;
}

// Coefficients of AS 241's PPND16: |p − ½| <= 0.425, then the tails with r = sqrt(−log p) up to 5 and beyond.
constexpr std::array kA{3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3,
                        1.3731693765509461125e4, 4.5921953931549871457e4, 6.7265770927008700853e4,
                        3.3430575583588128105e4, 2.5090809287301226727e3};
constexpr std::array kB{1.0000000000000000000e0, 4.2313330701600911252e1, 6.8718700749205790830e2,
                        5.3941960214247511077e3, 2.1213794301586595867e4, 3.9307895800092710610e4,
                        2.8729085735721942674e4, 5.2264952788528545610e3};
constexpr std::array kC{1.42343711074968357734e0,  4.63033784615654529590e0, 5.76949722146069140550e0,
                        3.64784832476320460504e0,  1.27045825245236838258e0, 2.41780725177450611770e-1,
                        2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr std::array kD{1.0000000000000000000e0,   2.05319162663775882187e0,  1.67638483018380384940e0,
                        6.89767334985100004550e-1, 1.48103976427480074590e-1, 1.51986665636164571966e-2,
                        5.47593808499534494600e-4, 1.05075007164441684324e-9};
constexpr std::array kE{6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,
                        2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                        2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr std::array kF{1.0000000000000000000e0,   5.99832206555887937690e-1, 1.36929880922735805310e-1,
                        1.48753612908506148525e-2, 7.86869131145613259100e-4, 1.84631831751005468180e-5,
                        1.42151175831644588870e-7, 2.04426310338993978564e-15};

}  // namespace

Random::Random(std::uint64_t seed, std::string_view name) : key_(mix(mix(seed + kGolden) ^ fnv1a(name))) {}

Random::Random(std::uint64_t seed, std::string_view name, std::uint64_t item) : Random(seed, name) {
  key_ = mix(key_ ^ mix(item * kGolden + 1));
}

std::uint64_t Random::bits() { return mix(key_ ^ mix(++counter_ * kGolden)); }

double Random::uniform() { return double(bits() >> 11) * 0x1p-53; }

double Random::normal() { return normal_quantile((double(bits() >> 12) + 0.5) * 0x1p-52); }

double normal_quantile(double p) {
  const double q = p - 0.5;
  if (std::abs(q) <= 0.425) {
    const double r = 0.180625 - q * q;
    return q * polynomial(kA, r) / polynomial(kB, r);
  }
  const double r = std::sqrt(-fixed_log(q < 0 ? p : 1 - p));
  const double z = r <= 5 ? polynomial(kC, r - 1.6) / polynomial(kD, r - 1.6)
                          : polynomial(kE, r - 5) / polynomial(kF, r - 5);
  return q < 0 ? -z : z;
}

}  // namespace sim::sensor_errors
