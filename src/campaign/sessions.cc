#include "armtrue/campaign/sessions.h"

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>

#include "armtrue/kinematics/parameters.h"

namespace armtrue {

std::string session_name(const Campaign& campaign, int row) {
  return campaign.session.empty() || row >= campaign.rows()
             ? ""
             : campaign.session_names[campaign.session[row]];
}

Pose common_from_session(const Robot& robot, const std::string& session) {
  const auto known = robot.sessions.find(session);
  return known == robot.sessions.end() ? Pose{} : robot.chain.base * inverse(known->second.base);
}

namespace {

void require_known_contacts(const Campaign& training, const Campaign& held_out) {
  // A corner that no training image shows is where its board is, a face where its artefact is.
  const auto placed = [](const Campaign& campaign, const Touch& touch) {
    const std::string& name = campaign.contact_names[touch.contact];
    const size_t slash = name.find('/');
    return name.substr(0, touch.is_pixel ? name.find('/', slash + 1) : slash);
  };
  std::set<std::string> known;
  for (const Touch& touch : training.touch)
    if (touch.contact >= 0) known.insert(placed(training, touch));
  for (const Touch& touch : held_out.touch)
    if (touch.contact >= 0 && !known.contains(placed(held_out, touch)))
      throw std::invalid_argument(
          held_out.source + ": the contact '" + held_out.contact_names[touch.contact] +
          "' has held-out poses but no training pose that shows where it is; touch it in more "
          "poses, or leave it out");
}

}  // namespace

void require_known_sessions(const Campaign& training, const Campaign& held_out) {
  const auto names_of = [](const Campaign& campaign) {
    std::set<std::string> names;
    for (int session : campaign.session) names.insert(campaign.session_names[session]);
    return names;
  };
  require_known_contacts(training, held_out);
  const std::set<std::string> known = names_of(training);
  for (const std::string& name : names_of(held_out))
    if (!known.contains(name))
      throw std::invalid_argument(held_out.source + ": session '" + name +
                                  "' has held-out poses but no training pose that shows where its "
                                  "instrument stood; measure more poses in it, or leave it out");
  if (known.size() > 1 && held_out.rows() > 0 && held_out.session.empty())
    throw std::invalid_argument(
        held_out.source +
        ": the training poses are of several sessions, and the held-out poses do not say of which "
        "they are; add the column 'session'");
}

std::vector<std::vector<int>> rows_by_session(const Campaign& campaign) {
  std::vector<std::vector<int>> sessions(std::max<size_t>(1, campaign.session_names.size()));
  for (int row = 0; row < campaign.rows(); ++row)
    sessions[campaign.session.empty() ? 0 : campaign.session[row]].push_back(row);
  std::erase_if(sessions, [](const std::vector<int>& rows) { return rows.empty(); });
  if (sessions.empty()) sessions.emplace_back();
  return sessions;
}

Robot robot_at_row(const Robot& robot, const Campaign& campaign, int row) {
  Robot there = robot;
  there.sessions.clear();
  const auto found = robot.sessions.find(session_name(campaign, row));
  if (found == robot.sessions.end()) return there;
  move_to(found->second, there);
  return there;
}

void move_to(const Session& session, Robot& robot) {
  robot.chain.base = session.base;
  for (const auto& [link, zero] : session.zero) zero_of(robot.chain.links[link]) = zero;
  for (const auto& [name, deviation] : session.std) robot.std[name] = deviation;
}

Campaign in_common_frame(Campaign campaign, const Robot& robot) {
  for (int row = 0; row < campaign.rows() && !robot.sessions.empty(); ++row) {
    const Pose common_from_own = common_from_session(robot, session_name(campaign, row));
    if (!campaign.position.empty())
      campaign.position[row] = common_from_own * campaign.position[row];
    if (campaign.has_orientation())
      campaign.orientation[row] =
          Eigen::Quaterniond(common_from_own.rotation) * campaign.orientation[row];
    if (!campaign.whitening.empty()) {  // W of the axes of the session
      Eigen::Matrix<double, 6, 6>& columns = campaign.whitening[row];
      for (int k : {0, 3})
        columns.middleCols<3>(k) =
            (columns.middleCols<3>(k) * common_from_own.rotation.transpose()).eval();
    }
    if (!campaign.force_n.empty())
      campaign.force_n[row] = common_from_own.rotation * campaign.force_n[row];
  }
  return campaign;
}

bool is_of_each_session(const Parameter& parameter, const Robot& robot) {
  return parameter.owner == Owner::base ||
         std::ranges::any_of(robot.identify_per_session,
                             [&](const std::string& name) { return Parameter(name) == parameter; });
}

std::vector<int> own_parameters(const Robot& robot) {
  std::vector<int> own(kParametersPerPose);
  std::iota(own.begin(), own.end(), kFirstBaseParameter);
  for (const std::string& name : robot.identify_per_session) {
    if (Parameter(name) == Parameter(Owner::base, "", Parameter::kWhole)) continue;  // always
    const auto parameter = find_parameter(robot.chain, name);
    if (!parameter || !is_zero_offset(robot.chain, *parameter))
      throw std::invalid_argument("identify_per_session: '" + name +
                                  "' is no zero offset of the robot; a session has its base for "
                                  "itself and, if named here, offsets such as A2.theta");
    if (std::find(own.begin(), own.end(), *parameter) == own.end()) own.push_back(*parameter);
  }
  return own;
}

}  // namespace armtrue
