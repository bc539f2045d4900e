#include "sim/pages/pictures.h"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/files/inner_file.h"
#include "sim/files/text.h"
#include "sim/recording/image_size.h"

namespace sim::pages {
std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

namespace {

// The 3-sigma ellipse of a search, as an SVG element.
std::string ellipse(double u, double v, const Eigen::Matrix2d& S, bool used) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(S);
  const Eigen::Vector2d half = 3 * solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  const Eigen::Vector2d along = solver.eigenvectors().col(1);
  return fmt::format(
      "<ellipse class='{}' transform='translate({:.1f} {:.1f})rotate({:.1f})' rx='{:.1f}' ry='{:.1f}'/>",
      used ? "used" : "missed", u + 0.5, v + 0.5, std::atan2(along.y(), along.x()) * 180 / std::numbers::pi,
      half(1), half(0));
}

std::string patch(double u, double v) {
  return fmt::format("<rect class='used' x='{:.1f}' y='{:.1f}' width='11' height='11'/>", u - 5, v - 5);
}

// What was looked for, frame by frame.
class Searches {
 public:
  explicit Searches(const Table& table)
      : t_(table.seconds("timestamp")),
        u_(table.numbers("u")),
        v_(table.numbers("v")),
        uu_(table.numbers("S_uu")),
        uv_(table.numbers("S_uv")),
        vv_(table.numbers("S_vv")),
        found_u_(table.numbers("found_u")),
        found_v_(table.numbers("found_v")) {}

  std::string at(double t) const {
    std::string svg;
    for (std::size_t i = 0; i < t_.size(); ++i) {
      if (std::abs(t_[i] - t) > 1e-4) continue;
      Eigen::Matrix2d S;
      S << uu_[i], uv_[i], uv_[i], vv_[i];
      const bool used = std::isfinite(found_u_[i]);
      svg += ellipse(u_[i], v_[i], S, used);
      if (used) svg += patch(found_u_[i], found_v_[i]);
    }
    return svg;
  }

 private:
  Column t_, u_, v_, uu_, uv_, vv_, found_u_, found_v_;
};

/// Throws FileError where the file is no PNG: the page must not carry anything else.
std::string picture(const std::filesystem::path& file, double t, const std::string& over) {
  const std::string png = files::read_text(file, files::kMostOfImage);
  const auto size = recording::image_size(png);
  if (!size || !png.starts_with("\x89PNG")) throw files::FileError(file, "is not a PNG image");
  return fmt::format(
      "<svg class='picture' xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {0} {1}' role='img' "
      "aria-label='head camera at {2} s'><image width='{0}' height='{1}' "
      "href='data:image/png;base64,{3}'/>{4}</svg>",
      size->width, size->height, t, base64(png), over);
}

}  // namespace

std::vector<Picture> pictures(const RunData& run, int count) {
  std::vector<Picture> all;
  const auto camera = run.recording / "mav0/cam0";
  if (!std::filesystem::exists(camera / "data.csv")) return all;
  const Table frames(camera / "data.csv");
  const auto t = frames.seconds("timestamp");
  const auto& names = frames.text("filename");
  const auto sought = run.searches ? std::optional<Searches>(*run.searches) : std::nullopt;
  for (int k = 0; k < count && !t.empty(); ++k) {
    const std::size_t i = k * (t.size() - 1) / std::max(1, count - 1);
    const double since_start = t[i] - t[0], shown = std::round(10 * since_start) / 10;
    all.push_back({shown, picture(files::inner_file(camera / "data", names[i]), shown,
                                  sought ? sought->at(since_start) : "")});
  }
  return all;
}

}  // namespace sim::pages
