#include "sim/export/export.h"

#include <algorithm>
#include <stdexcept>

#include "sim/export/export_context.h"
#include "sim/export/export_euroc.h"
#include "sim/export/export_kitti.h"
#include "sim/export/export_mcap.h"
#include "sim/export/export_openvins.h"
#include "sim/export/export_orbslam3.h"
#include "sim/export/export_tum.h"

namespace sim::exports {
namespace {

struct Format {
  std::string name;
  void (*write)(const ExportContext&);
  bool knows_lenses = true;  ///< else the images are always undistorted
  int passes = 1;            ///< how often the recording is read
};

const std::vector<Format>& formats() {
  static const std::vector<Format> all{
      {"euroc", export_euroc}, {"tum", export_tum, false},    {"kitti", export_kitti, false},
      {"mcap", export_mcap},   {"orbslam3", export_orbslam3}, {"openvins", export_openvins, true, 2}};
  return all;
}

}  // namespace

const std::vector<std::string>& export_formats() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Format& format : formats()) all.push_back(format.name);
    return all;
  }();
  return names;
}

void export_run(const ExportedRun& run, const std::string& format, const std::filesystem::path& folder,
                files::Existing existing) {
  const auto found =
      std::find_if(formats().begin(), formats().end(), [&](const Format& f) { return f.name == format; });
  if (found == formats().end()) throw std::out_of_range("no export format " + format);
  files::AtomicFolder durable(folder, existing);
  found->write(ExportContext(run, durable.path(), run.undistort || !found->knows_lenses, found->passes));
  durable.commit();
}

}  // namespace sim::exports
