#pragma once

#include <vector>

#include "armtrue/campaign/campaign.h"

namespace armtrue {

/// `count` of the rows at equal steps of their order; all if there are fewer.
std::vector<int> evenly_chosen(const std::vector<int>& rows, long count);

/// The same for a search for mistakes. Of images: all rows of 15 images of each camera and board,
/// because all corners together show where the camera is.
std::vector<int> readings_evenly_chosen(const Campaign& campaign, const std::vector<int>& rows,
                                        long count);

/// Rows of one image: of one pose, repeat, camera and board.
std::vector<std::vector<int>> rows_by_image(const Campaign& campaign);

/// Of a campaign of images, the rows of `images` images of each camera and board and of `corners`
/// corners of each image, both at equal steps. Many images show more than many corners: each shows
/// six numbers of a pose.
std::vector<int> corners_evenly_chosen(const Campaign& campaign, long images, long corners);

/// About `count` rows, at equal steps of the rows of each session, target and quantity; at least 50
/// of each, if there are as many, so that every base, target and anchor can still be located.
std::vector<int> thinned_rows(const Campaign& campaign, int count);

/// All rows of about `count` poses, at equal steps of the poses of each session in the order of
/// their ids; at least 30 of each session, if there are as many. The order of the rows does not
/// change the choice.
std::vector<int> rows_of_some_poses(const Campaign& campaign, long count);

/// About `count` of these rows, in ascending order: of the replicates of each session, pose and
/// channel rows at equal steps, in proportion to their number; at least one.
std::vector<int> rows_of_some_visits(const Campaign& campaign, const std::vector<int>& rows,
                                     long count);

}  // namespace armtrue
