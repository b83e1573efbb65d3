#include "renderer/dataset/pages/statistics.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "base/plural.h"
#include "base/text.h"

namespace fire3dv::dataset {
namespace {

using nlohmann::json;

constexpr double kDark = 8, kBright = 247;

// limits: ascending upper bounds (exclusive) of all ranges but the last.
class Counter {
 public:
  Counter(std::string title, std::string unit, std::vector<double> limits) : limits_(std::move(limits)) {
    histogram_.title = std::move(title);
    histogram_.unit = std::move(unit);
    histogram_.counts.resize(limits_.size() + 1);
    const auto text = [](double value) { return json(value).dump(); };
    const auto plain = [&](double value) {
      return value == static_cast<double>(static_cast<int64_t>(value))
                 ? std::to_string(static_cast<int64_t>(value))
                 : text(value);
    };
    histogram_.ranges.push_back("< " + plain(limits_.front()));
    for (size_t i = 1; i < limits_.size(); ++i)
      histogram_.ranges.push_back(plain(limits_[i - 1]) + " - " + plain(limits_[i]));
    histogram_.ranges.push_back(">= " + plain(limits_.back()));
  }
  void add(double value) {
    const auto at = std::upper_bound(limits_.begin(), limits_.end(), value);
    ++histogram_.counts[static_cast<size_t>(at - limits_.begin())];
  }
  const Histogram& histogram() const { return histogram_; }

 private:
  std::vector<double> limits_;
  Histogram histogram_;
};

// Values of the parts of drawn parameters, and the images of each text.
struct DrawnParameters {
  std::map<std::string, std::vector<double>> numbers;
  std::map<std::string, std::map<std::string, uint64_t>> texts;
};

void add_drawn(const json& line, DrawnParameters& parameters) {
  const auto drawn = line.find("drawn");
  if (drawn == line.end()) return;
  for (const auto& [name, value] : drawn->items()) {
    if (value.is_string()) ++parameters.texts[name][value.get<std::string>()];
    if (value.is_number()) parameters.numbers[name].push_back(value.get<double>());
    for (size_t i = 0; value.is_array() && i < value.size(); ++i)
      parameters.numbers[name + " [" + std::to_string(i) + "]"].push_back(value[i].get<double>());
  }
}

// Ten ranges of equal width from the least to the largest value.
Histogram histogram_of(const std::string& name, const std::vector<double>& values) {
  constexpr int kRanges = 10;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double width = (*most - *least) / kRanges;
  Histogram histogram;
  histogram.title = name;
  const auto text = [](double value) {
    char number[32];
    std::snprintf(number, sizeof number, "%.4g", value);
    return std::string(number);
  };
  if (!(width > 0)) {
    histogram.ranges = {text(*least)};
    histogram.counts = {values.size()};
    return histogram;
  }
  histogram.counts.resize(kRanges);
  for (int i = 0; i < kRanges; ++i)
    histogram.ranges.push_back(text(*least + i * width) + " - " + text(*least + (i + 1) * width));
  for (const double value : values)
    ++histogram.counts[std::min<size_t>(kRanges - 1, static_cast<size_t>((value - *least) / width))];
  return histogram;
}

}  // namespace

Statistics count(const Description& description, const Layout& layout, const offline::FrameLines& lines) {
  Statistics statistics;
  statistics.images = lines.size();
  statistics.warnings = description.warnings;
  Counter visibility("Visible share of the silhouette", "", {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9});
  Counter sizes("Visible pixels of an instance", "", {10, 30, 100, 300, 1000, 3000, 10000, 30000, 100000});
  Counter distances("Distance along the camera's axis", "m", {0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20});
  Counter brightness("Mean colour of an image", "of 255", {25, 50, 75, 100, 125, 150, 175, 200, 225});
  uint64_t dark = 0, bright = 0, beyond_range = 0;
  std::set<uint32_t> seen, rescaled;
  DrawnParameters drawn;
  for (const auto& [image, text] : lines) {
    const json line = json::parse(text, nullptr, false);
    if (!line.is_object()) continue;
    add_drawn(line, drawn);
    const double mean = line.value("brightness", 0.0);
    brightness.add(mean);
    dark += mean < kDark;
    bright += mean > kBright;
    beyond_range += line.value("beyond_range_px", uint64_t{0}) != 0;
    const json instances = line.value("instances", json::array());
    std::set<uint32_t> objects_here;
    bool shows_any = false;
    for (const json& instance : instances) {
      ++statistics.labels;
      const auto object = instance.value("obj_id", 0u);
      ObjectCounts& counts = statistics.objects[object];
      const double distance_m = instance.at("cam_t_m2c").at(2).get<double>() / 1000;
      counts.least_m = counts.labels == 0 ? distance_m : std::min(counts.least_m, distance_m);
      counts.most_m = counts.labels == 0 ? distance_m : std::max(counts.most_m, distance_m);
      ++counts.labels;
      counts.images += objects_here.insert(object).second;
      counts.truncated += instance.value("truncated", false);
      if (const auto share = instance.find("visib_fract"); share != instance.end()) {
        statistics.has_silhouettes = true;
        visibility.add(share->get<double>());
      }
      const auto visible_px = instance.value("px_count_visib", uint64_t{0});
      sizes.add(static_cast<double>(visible_px));
      distances.add(distance_m);
      if (visible_px != 0) seen.insert(instance.value("instance", 0u));
      shows_any |= visible_px != 0;
      if (instance.value("rescaled", false)) rescaled.insert(instance.value("instance", 0u));
    }
    statistics.empty_images += !shows_any;
    for (const json& point : line.value("keypoints", json::array())) {
      const std::string state = point.value("state", "");
      ++statistics.keypoints[point.value("name", "")][state == "visible" ? 0 : state == "hidden" ? 1 : 2];
    }
  }
  if (statistics.has_silhouettes) statistics.histograms.push_back(visibility.histogram());
  for (const Counter* counter : {&sizes, &distances, &brightness})
    statistics.histograms.push_back(counter->histogram());
  for (const auto& [name, texts] : drawn.texts) {
    Histogram& histogram = statistics.drawn.emplace_back();
    histogram.title = name;
    for (const auto& [text, images] : texts) {
      histogram.ranges.push_back(text.substr(0, 20));
      histogram.counts.push_back(images);
    }
  }
  for (const auto& [name, values] : drawn.numbers) statistics.drawn.push_back(histogram_of(name, values));

  const auto warn = [&](uint64_t images, const std::string& what) {
    if (images != 0) statistics.warnings.push_back(counted(images, "image") + what);
  };
  warn(statistics.empty_images, " without a visible labelled instance");
  warn(dark, " nearly black (mean below 8 of 255): add lights, or --exposure");
  warn(bright, " nearly white (mean above 247 of 255): lower --exposure");
  if (const auto depth = layout.depth16(description))
    warn(beyond_range,
         std::string(" with surfaces beyond the range of the depth images (") + depth->beyond + ")");
  std::vector<std::string> unseen, resized;
  for (const Instance& instance : description.instances) {
    if (!seen.contains(instance.number)) unseen.push_back(instance.path);
    if (rescaled.contains(instance.number)) resized.push_back(instance.path);
  }
  if (!unseen.empty())
    statistics.warnings.push_back(counted(unseen.size(), "instance") +
                                  " visible in no image: " + list_names(unseen));
  if (!resized.empty())
    statistics.warnings.push_back(counted(resized.size(), "instance") +
                                  " drawn in another size than the model: " + list_names(resized) +
                                  "; poses of streams replace the scale of the file");
  return statistics;
}

}  // namespace fire3dv::dataset
