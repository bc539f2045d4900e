#include "sim/pages/pictures.h"

#include "sim/files/csv.h"
#include "sim/files/text.h"
#include "sim/recording/recording_format.h"

namespace sim::pages {

std::vector<fs::path> image_files(const std::vector<Frame>& frames, const fs::path& recording,
                                  const std::string& sensor) {
  std::vector<fs::path> images(frames.size());
  const fs::path folder = recording / "mav0" / sensor;
  if (recording.empty() || !fs::exists(folder / "data.csv")) return images;
  files::CsvReader list(folder / "data.csv");
  const bool of_rig = list.titles().size() == 3;  // the third column: the reading's frame
  std::size_t row = 0;
  while (list.next()) {
    const slam::Stamp t = slam::Stamp(list.integer(of_rig ? 2 : 0)) - recording::kEpoch;
    while (row < frames.size() && frames[row].t < t) ++row;
    if (row < frames.size() && frames[row].t == t)
      images[row] = list.text(1).find('/') == list.text(1).npos  // symbolic links: the content has a hash
                        ? folder / "data" / list.text(1)
                        : files::contained_path(folder / "data", list.text(1));
  }
  for (std::size_t i = 1; of_rig && i < images.size(); ++i)
    if (images[i].empty()) images[i] = images[i - 1];
  return images;
}

Pictures::Pictures(const fs::path& recording)
    : folder_(recording), manifest_(recording), setup_(recording::RecordingReader(recording).setup()) {}

slam::RigReading Pictures::read(const rig::RigSensor& sensor, const fs::path& file) const {
  return recording::read_rig_file(folder_, manifest_, sensor, file.filename().string());
}

}  // namespace sim::pages
