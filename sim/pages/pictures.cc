#include "sim/pages/pictures.h"

#include "sim/files/csv.h"
#include "sim/files/text.h"
#include "sim/recording/recording_format.h"

namespace sim::pages {

Pictures::Pictures(const fs::path& recording)
    : folder_(recording), manifest_(recording), setup_(recording::read_setup(recording, manifest_)) {}

std::vector<std::string> Pictures::files(const std::vector<Frame>& frames, const std::string& sensor) const {
  std::vector<std::string> images(frames.size());
  const std::string list = recording::recording_format::sensor_rows(sensor);
  if (!manifest_.lists(list)) return images;
  files::CsvReader rows(manifest_.check(list));
  const bool of_rig = rows.titles().size() == 3;  // the third column: the reading's frame
  std::size_t frame = 0;
  while (rows.next()) {
    const slam::Stamp t = slam::Stamp(rows.integer(of_rig ? 2 : 0)) - recording::kEpoch;
    while (frame < frames.size() && frames[frame].t < t) ++frame;
    if (frame < frames.size() && frames[frame].t == t) images[frame] = rows.text(1);
  }
  for (std::size_t i = 1; of_rig && i < images.size(); ++i)
    if (images[i].empty()) images[i] = images[i - 1];
  return images;
}

slam::RigReading Pictures::read(const rig::RigSensor& sensor, const std::string& file) const {
  return recording::read_rig_file(folder_, manifest_, sensor, file);
}

}  // namespace sim::pages
