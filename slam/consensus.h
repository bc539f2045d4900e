// Which matches belong together: one match's word on the state predicts all the others.
#pragma once

#include <vector>

#include "slam/kalman.h"

namespace slam {

/// The matches (measurements of `joint`) that agree: 1-point RANSAC of Civera et al. 2010, with every match
/// as the hypothesis once and each other match judged by its chi-square given the hypothesis (so prior
/// correlations count, as in joint compatibility, Neira & Tardós 2001); then those that agree given all the
/// consenting ones are rescued. Indices in rising order. gate: chi-square bound of a match of 2 rows.
std::vector<std::size_t> largest_consensus(const Joint& joint, double gate);

/// Replaces the noise R of each measurement by ratio² R in S.
void sharpen(Joint& joint, const std::vector<Measurement>& measurements, double ratio);

/// The part of a joint measurement that the given measurements make.
void select(const Joint& joint, const std::vector<std::size_t>& keep, Joint& selected);

}  // namespace slam
