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
#include "import/column_mapping.h"

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

// The names in a sensor_msgs/msg/JointState, behind its header.
std::vector<std::string> joint_names_of(CdrReader& reader) {
  std::vector<std::string> names;
  for (std::uint32_t left = reader.uint32(); left > 0; --left) names.push_back(reader.string());
  return names;
}

std::vector<BagTopic> all_of(const std::map<std::string, std::string>& types) {
  std::vector<BagTopic> topics;
  for (const auto& [name, type] : types) topics.push_back({name, type});
  return topics;
}

// Topics by name of a wanted joint.
using TopicsOfJoints = std::map<std::string, std::set<std::string>>;

TopicsOfJoints topics_of_joints(const std::string& path, const std::set<std::string>& joints,
                                const std::map<std::string, std::string>& fitting) {
  TopicsOfJoints topics;
  visit_bag(path, {[&](const BagTopic& topic) { return fitting.contains(topic.name); },
                   [&](const BagTopic& topic, std::int64_t, std::string_view message) {
                     try {
                       CdrReader reader(message);
                       const Header header(reader);
                       for (std::string joint : joint_names_of(reader)) {
                         if (!joints.contains(joint) && joint.ends_with(kJointEnding))
                           joint.resize(joint.size() - kJointEnding.size());
                         if (joints.contains(joint)) topics[joint].insert(topic.name);
                       }
                     } catch (const CutMessage&) {  // said when it is read
                     }
                   }});
  return topics;
}

// Of several topics with joint states those that hold the wanted joints: one that has them all, or
// else all that have some. Empty if none has, or a joint stands in two of them.
std::set<std::string> topics_with_joints(const TopicsOfJoints& topics, size_t wanted) {
  std::map<std::string, size_t> counts;
  bool stands_twice = false;
  for (const auto& [joint, of] : topics) {
    stands_twice = stands_twice || of.size() > 1;
    for (const std::string& topic : of) ++counts[topic];
  }
  std::set<std::string> whole, some;
  for (const auto& [topic, count] : counts) {
    some.insert(topic);
    if (count == wanted) whole.insert(topic);
  }
  if (whole.size() == 1) return whole;
  return whole.empty() && !stands_twice ? some : std::set<std::string>();
}

std::vector<BagTopic> choose_topics(const std::string& path, const BagSelection& selection) {
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
  if (fitting.size() > 1 && !selection.joints.empty()) {
    const std::set<std::string> chosen = topics_with_joints(
        topics_of_joints(path, selection.joints, fitting), selection.joints.size());
    if (!chosen.empty())
      std::erase_if(fitting, [&](const auto& topic) { return !chosen.contains(topic.first); });
    if (!chosen.empty()) return all_of(fitting);
  }
  if (fitting.size() > 1) {
    std::set<std::string> names;
    for (const auto& [name, type] : fitting) names.insert(name);
    throw InputError(fmt::format("{}: the topics {} hold {}; say which: --{}-topic {}", path,
                                 list(names), what, selection.of_joints ? "joints" : "points",
                                 *names.begin()));
  }
  return all_of(fitting);
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

class BagTable {
 public:
  // `topics`: several of joint states, or one of any type.
  BagTable(const std::vector<BagTopic>& topics, const BagSelection& selection, std::string file)
      : topic_(topics.front()),
        selection_(selection),
        file_(std::move(file)),
        type_(pose_type(topic_.type)) {
    for (const BagTopic& topic : topics) names_.push_back(topic.name);
  }

  void take(const BagTopic& topic, std::int64_t logged_ns, std::string_view message) {
    topic_.name = topic.name;
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
    table.file = fmt::format("{}({})", file_, fmt::join(names_, ", "));
    table.header_line = 1;
    table.separator = '\0';
    table.columns.push_back({"__time", ""});
    for (const std::string& name : columns_.names()) table.columns.push_back({name, ""});
    const bool has_stamps = stamped_.size() == names_.size();
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
    const std::vector<std::string> names = joint_names_of(reader);
    Reading reading{header.stamp_ns, logged_ns_, messages_, {}};
    const size_t positions = reader.uint32();
    if (positions != 0 && positions != names.size()) throw CutMessage();
    for (size_t k = 0; k < positions; ++k)
      reading.cells.emplace_back(columns_.of(topic_.name + "/" + names[k] + "/position"),
                                 reader.float64());
    if (positions > 0) add(std::move(reading));
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
    add(std::move(reading));
  }

  void add(Reading reading) {
    if (reading.stamp_ns != 0) stamped_.insert(topic_.name);
    readings_.push_back(std::move(reading));
  }

  BagTopic topic_;                  // of the message
  std::vector<std::string> names_;  // of the topics
  std::set<std::string> stamped_;   // those with times in their headers
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
  const std::vector<BagTopic> topics = choose_topics(path, selection);
  BagTable table(topics, selection, path);
  visit_bag(path, {[&](const BagTopic& one) {
                     return std::ranges::find(topics, one.name, &BagTopic::name) != topics.end();
                   },
                   [&](const BagTopic& topic, std::int64_t logged_ns, std::string_view message) {
                     table.take(topic, logged_ns, message);
                   }});
  return table.table();
}

}  // namespace armtrue
