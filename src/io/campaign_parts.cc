#include "io/campaign_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "armtrue/campaign/turns.h"
#include "armtrue/kinematics/units.h"

namespace armtrue {
namespace {

constexpr double kSameConfiguration = 0.1 * kDegree;  // [rad], of a travel [m]

template <typename T>
void append_column(std::vector<T>& all, const std::vector<T>& part) {
  all.insert(all.end(), part.begin(), part.end());
}

void append_column(JointRows& all, const JointRows& part) {
  for (const auto& row : part) all.push_back(row);
}

// The indices in the whole campaign of the names of a part.
std::vector<int> numbers_of(const std::vector<std::string>& names, TextIndex& index) {
  std::vector<int> numbers;
  for (const std::string& name : names) numbers.push_back(index.of(name));
  return numbers;
}

// A row that needs no name and has none gets index 0.
void append_numbers(std::vector<int>& all, const std::vector<int>& part,
                    const std::vector<int>& numbers) {
  for (int number : part) all.push_back(number < 0 ? 0 : numbers[number]);
}

}  // namespace

void JoinedCampaign::append(const CampaignPart& part) {
  const Campaign& rows = part.rows;
  if (blank_line_ != 0 && part.first_line != 0) table_.fail_blank(blank_line_);
  if (part.blank_line != 0) blank_line_ = part.blank_line;

  Campaign& all = campaign_;
  const std::vector<int> poses = numbers_of(rows.pose_ids, indices_.poses);
  for (size_t k = 0; k < rows.q.size(); ++k) {
    const int pose = poses[rows.pose[k]];
    check_configuration(pose, rows.q[k], rows.line[k], all.rows());
    all.pose.push_back(pose);
    all.q.push_back(rows.q[k]);
    all.line.push_back(rows.line[k]);
  }
  if (part.failure) std::rethrow_exception(part.failure);

  append_numbers(all.target, rows.target, numbers_of(rows.target_names, indices_.targets));
  append_numbers(all.session, rows.session, numbers_of(rows.session_names, indices_.sessions));
  const std::vector<int> anchors = numbers_of(rows.anchor_names, indices_.anchors);
  for (size_t k = 0; k < rows.anchor.size(); ++k) {
    const bool is_touch = !rows.touch.empty() && rows.touch[k].contact >= 0;
    const bool has_anchor = rows.distance[k] > 0 && !is_touch;
    all.anchor.push_back(has_anchor ? anchors[rows.anchor[k]] : 0);
  }
  const std::vector<int> contacts = numbers_of(rows.contact_names, indices_.contacts);
  for (Touch touch : rows.touch) {
    if (touch.contact >= 0) touch.contact = contacts[touch.contact];
    all.touch.push_back(touch);
  }
  all.metre_per_pixel = std::max(all.metre_per_pixel, rows.metre_per_pixel);
  append_column(all.profile, rows.profile);
  append_column(all.position, rows.position);
  append_column(all.distance, rows.distance);
  append_column(all.repeat, rows.repeat);
  append_column(all.orientation, rows.orientation);
  append_column(all.time_s, rows.time_s);
  append_column(all.sigma_position, rows.sigma_position);
  append_column(all.sigma_orientation, rows.sigma_orientation);
  append_column(all.whitening, rows.whitening);
  append_column(all.arrival, rows.arrival);
  append_column(all.stroke, rows.stroke);
  append_column(all.payload_kg, rows.payload_kg);
  append_column(all.motor_torque_nm, rows.motor_torque_nm);
  append_column(all.force_n, rows.force_n);
  append_column(all.temperature_c, rows.temperature_c);
  all.skipped_rows += rows.skipped_rows;
}

void JoinedCampaign::check_configuration(int pose, const JointVector& q, int line, int row) {
  if (pose == std::ssize(first_row_of_pose_)) {
    first_row_of_pose_.push_back(row);
    return;
  }
  const size_t first = first_row_of_pose_[pose];
  for (int k = 0; k < std::ssize(joints_); ++k) {
    const auto j = k;
    double difference = std::abs(q[j] - campaign_.q[first][j]);
    if (chain_ && is_within_one_turn(joint_link(*chain_, k)))
      difference = std::abs(std::remainder(difference, kTurn));
    if (difference > kSameConfiguration)
      table_.fail_in_line(
          line, columns_.q[k]->column,
          fmt::format(
              "pose '{}' stands {:.4g} {} away from its reading in line {}; rows that share "
              "a pose id are replicates of one configuration: give different "
              "configurations different ids",
              campaign_.pose_ids[pose], difference / joints_[k].si(), joints_[k].unit(),
              campaign_.line[first]));
  }
}

}  // namespace armtrue
