/* A library of a later version of gaitslam_estimator.h. */
unsigned gaitslam_estimator_version(void);
unsigned gaitslam_estimator_version(void) { return 99; }
