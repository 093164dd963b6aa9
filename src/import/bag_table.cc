#include "import/bag_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "armtrue/text/input_error.h"
#include "import/bag.h"
#include "import/cdr.h"

namespace armtrue {
namespace {

constexpr std::string_view kJointState = "sensor_msgs/msg/JointState",
                           kTransforms = "tf2_msgs/msg/TFMessage";
constexpr size_t kCovariance = 36;
constexpr std::int64_t kSecond = 1'000'000'000;  // in ns

// The layout of a pose message, behind its header.
struct PoseType {
  std::string_view type;
  bool has_child = false;  // the name of the frame that is measured
  bool has_orientation = true;
  bool has_covariance = false;
  std::string_view fields =
      "position/x position/y position/z orientation/x orientation/y "
      "orientation/z orientation/w";
};
constexpr std::string_view kOfTransform =
    "translation/x translation/y translation/z rotation/x rotation/y rotation/z rotation/w";
constexpr PoseType kPoseTypes[] = {
    {"geometry_msgs/msg/PoseStamped"},
    {"geometry_msgs/msg/PoseWithCovarianceStamped", false, true, true},
    {"geometry_msgs/msg/PointStamped", false, false},
    {"geometry_msgs/msg/TransformStamped", true, true, false, kOfTransform},
    {"nav_msgs/msg/Odometry", true, true, true},
    {kTransforms, true, true, false, kOfTransform},
};

const PoseType* pose_type(std::string_view type) {
  const auto* const found = std::ranges::find(kPoseTypes, type, &PoseType::type);
  return found == std::end(kPoseTypes) ? nullptr : found;
}

std::string list(const std::set<std::string>& names) {
  return fmt::format("'{}'", fmt::join(names, "', '"));
}

BagTopic choose_topic(const std::string& path, const BagSelection& selection) {
  std::map<std::string, std::string> fitting;  // type by name
  std::set<std::string> all;
  visit_bag(path, {[&](const BagTopic& topic) {
                     all.insert(topic.name + " (" + topic.type + ")");
                     const bool fits = selection.of_joints ? topic.type == kJointState
                                                           : pose_type(topic.type) != nullptr;
                     if (fits && (selection.topic.empty() || topic.name == selection.topic))
                       fitting.emplace(topic.name, topic.type);
                     return false;
                   },
                   {}});
  const char* const what =
      selection.of_joints
          ? "joint states (sensor_msgs/msg/JointState)"
          : "poses, points or transforms (PoseStamped, PoseWithCovarianceStamped, PointStamped, "
            "TransformStamped, Odometry, TFMessage)";
  if (fitting.empty())
    throw InputError(fmt::format(
        "{}: {} holds {}; it has {}", path,
        selection.topic.empty() ? "no topic" : "no topic '" + selection.topic + "' that", what,
        all.empty() ? "none" : list(all)));
  if (fitting.size() > 1) {
    std::set<std::string> names;
    for (const auto& [name, type] : fitting) names.insert(name);
    throw InputError(fmt::format("{}: the topics {} hold {}; say which: --{}-topic {}", path,
                                 list(names), what, selection.of_joints ? "joints" : "points",
                                 *names.begin()));
  }
  return {fitting.begin()->first, fitting.begin()->second};
}

// One reading of a topic: its time and its cells, by column.
struct Reading {
  std::int64_t stamp_ns, logged_ns;
  int message;
  std::vector<std::pair<size_t, double>> cells;
};

class Columns {
 public:
  size_t of(const std::string& name) {
    const auto [place, is_new] = places_.try_emplace(name, names_.size());
    if (is_new) names_.push_back(name);
    return place->second;
  }
  const std::vector<std::string>& names() const { return names_; }

 private:
  std::map<std::string, size_t> places_;
  std::vector<std::string> names_;
};

// std_msgs/msg/Header
struct Header {
  explicit Header(CdrReader& reader) {
    const std::int64_t seconds = reader.int32();
    stamp_ns = seconds * kSecond + reader.uint32();
    frame = reader.string();
  }
  std::int64_t stamp_ns;
  std::string frame;
};

class BagTable {
 public:
  BagTable(BagTopic topic, const BagSelection& selection, std::string file)
      : topic_(std::move(topic)),
        selection_(selection),
        file_(std::move(file)),
        type_(pose_type(topic_.type)) {}

  void take(std::int64_t logged_ns, std::string_view message) {
    ++messages_;
    try {
      CdrReader reader(message);
      logged_ns_ = logged_ns;
      if (selection_.of_joints)
        take_joints(reader);
      else if (topic_.type == kTransforms)
        for (std::uint32_t left = reader.uint32(); left > 0; --left) take_pose(reader);
      else
        take_pose(reader);
    } catch (const CutMessage& cut) {
      throw InputError(fmt::format("{}: message {} of '{}' {}; record it again", file_, messages_,
                                   topic_.name, cut.what()));
    }
  }

  PlainTable table() {
    if (topic_.type == kTransforms && selection_.body.empty() && children_.size() > 1)
      throw InputError(
          fmt::format("{}: '{}' holds transforms to {}; name the frame that is on the robot: "
                      "--body NAME",
                      file_, topic_.name, list(children_)));
    if (readings_.empty())
      throw InputError(
          children_.empty()
              ? fmt::format("{}: '{}' has no message; record it again", file_, topic_.name)
              : fmt::format("{}: '{}' has no transform to '{}' (--body); it has those to {}", file_,
                            topic_.name, selection_.body, list(children_)));
    if (parents_.size() > 1)
      throw InputError(fmt::format(
          "{}: '{}' states poses in several frames, {}; record one frame, that of the instrument",
          file_, topic_.name, list(parents_)));
    PlainTable table;
    table.file = fmt::format("{}({})", file_, topic_.name);
    table.header_line = 1;
    table.separator = '\0';
    table.columns.push_back({"__time", ""});
    for (const std::string& name : columns_.names()) table.columns.push_back({name, ""});
    const bool has_stamps =
        std::ranges::any_of(readings_, [](const Reading& one) { return one.stamp_ns != 0; });
    if (!has_stamps) table.notes.push_back("times of the recorder: the headers have none");
    const auto time = [&](const Reading& one) { return has_stamps ? one.stamp_ns : one.logged_ns; };
    std::ranges::stable_sort(readings_, {}, time);
    for (const Reading& one : readings_) {
      const std::int64_t ns = time(one);
      PlainRow& row = table.rows.emplace_back();
      row.line = one.message;
      row.cells.resize(table.columns.size());
      row.cells.front() = fmt::format("{}.{:09d}", ns / kSecond, ns % kSecond);
      for (const auto& [column, value] : one.cells)
        row.cells[column + 1] = fmt::format("{:.16e}", value);
    }
    return table;
  }

 private:
  void take_joints(CdrReader& reader) {
    const Header header(reader);
    std::vector<std::string> names;
    for (std::uint32_t left = reader.uint32(); left > 0; --left) names.push_back(reader.string());
    Reading reading{header.stamp_ns, logged_ns_, messages_, {}};
    const size_t positions = reader.uint32();
    if (positions != 0 && positions != names.size()) throw CutMessage();
    for (size_t k = 0; k < positions; ++k)
      reading.cells.emplace_back(columns_.of(topic_.name + "/" + names[k] + "/position"),
                                 reader.float64());
    if (positions > 0) readings_.push_back(std::move(reading));
  }

  void take_pose(CdrReader& reader) {
    const Header header(reader);
    const std::string child = type_->has_child ? reader.string() : "";
    Reading reading{header.stamp_ns, logged_ns_, messages_, {}};
    std::string_view fields = type_->fields;
    for (int k = 0; k < (type_->has_orientation ? 7 : 3); ++k) {
      const size_t end = std::min(fields.find(' '), fields.size());
      reading.cells.emplace_back(
          columns_.of(fmt::format("{}/{}", topic_.name, fields.substr(0, end))), reader.float64());
      fields.remove_prefix(std::min(end + 1, fields.size()));
    }
    if (type_->has_covariance)
      for (size_t k = 0; k < kCovariance; ++k)
        reading.cells.emplace_back(
            columns_.of(fmt::format("{}/pose/covariance[{}]", topic_.name, k)), reader.float64());
    if (topic_.type == kTransforms) {
      children_.insert(child);
      if (!selection_.body.empty() && child != selection_.body) return;
    }
    parents_.insert(header.frame);
    readings_.push_back(std::move(reading));
  }

  BagTopic topic_;
  const BagSelection& selection_;
  std::string file_;
  const PoseType* type_;
  int messages_ = 0;
  std::int64_t logged_ns_ = 0;
  std::vector<Reading> readings_;
  Columns columns_;
  std::set<std::string> children_, parents_;  // frames
};

}  // namespace

PlainTable read_bag_table(const std::string& path, const BagSelection& selection) {
  const BagTopic topic = choose_topic(path, selection);
  BagTable table(topic, selection, path);
  visit_bag(path, {[&](const BagTopic& one) { return one.name == topic.name; },
                   [&](const BagTopic&, std::int64_t logged_ns, std::string_view message) {
                     table.take(logged_ns, message);
                   }});
  return table.table();
}

}  // namespace armtrue
