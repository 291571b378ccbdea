#!/bin/sh
# Builds the tests with the sanitizer of a preset (asan or tsan) and runs them, each room in one process, so that
# scenes that tests share are made once.
# usage: scripts/check_sanitizer.sh PRESET
set -eu
cd "$(dirname "$0")/.."
jobs=${JOBS:-$(nproc)}
case $1 in
asan) # All but whole scenes, most drives, statistics of many trials and comparisons with a slow oracle ray by ray: they take
  # minutes here, and repeat what the others go through. Nor is speed measured.
  GTEST_FILTER='-DetectorIn*:DetectorOn*:*WeavingDrive*:Isotropy*:*Agreement*:KittiDrive*:KittiOdometry.EveryStep*:NewerCollege*'
  GTEST_FILTER="$GTEST_FILTER:LidarOdometry.Follows*:LidarOdometry.TheSame*:LidarOdometry.AFeatureless*:LidarOdometry.Removes*"
  GTEST_FILTER="$GTEST_FILTER:LidarOdometry.RandomReturns*:LidarOdometry.Begins*:LidarOdometry.AScanDelivered*:LidarOdometry.StandsStill"
  GTEST_FILTER="$GTEST_FILTER:LidarOdometry.ADropped*:OdometryCovariance*:HardPlaces.ASudden*:HardPlaces.AScanOfFew*"
  GTEST_FILTER="$GTEST_FILTER:Detector.FindsAWall*:Detector.DetectionsCome*:Detector.FindsABox*:Detector.AStanding*"
  GTEST_FILTER="$GTEST_FILTER:Detector.WhatStops*:ScanlineSampler.Loses*:RaySearch.AgreesAt*:ObjectTracker.EstimatesVelocity*"
  GTEST_FILTER="$GTEST_FILTER:ObjectTracker.FollowsABraking*:Scene.ALonger*:Scene.AnotherSeed*"
  GTEST_FILTER="$GTEST_FILTER:*EverySceneIsTheSame*:Traffic.StopsAndStarts*:DetectionRunThreads.OdometryBeside*"
  GTEST_FILTER="$GTEST_FILTER:BenchmarkTest.Same*:BenchmarkTest.ARecording*:BenchmarkTest.Own*:BenchmarkTest.ARunIs*"
  # Own odometry, as in OnlineDetectorThreads.
  GTEST_FILTER="$GTEST_FILTER:LiveDetector.LabelsAre*:LiveDetector.OwnOdometry*"
  # The same code as SideBySideGivesTheSame.
  GTEST_FILTER="$GTEST_FILTER:OnlineDetectorThreads.IsOdometry*:OnlineDetectorThreads.AnyNumber*:OnlineDetectorThreads.CatchingUp*"
  GTEST_FILTER="$GTEST_FILTER:OnlineDetectorThreads.SideBySideTheLabels*:OnlineDetectorThreads.AScanThat*"
  GTEST_FILTER="$GTEST_FILTER:OnlineDetector.ARecordingThat*:OnlineDetector.GoesOn*"
  # The same code as StartUp.Unregistered*, StartUp.WherePlanes*, LidarOdometry.ATrajectorySnapshot* and, for
  # long scans, BackwardRegistration.*.
  GTEST_FILTER="$GTEST_FILTER:StartUp.Joint*:StartUp.TheSteps*:StartUp.MotionsThat*:StartUp.DropsA*"
  GTEST_FILTER="$GTEST_FILTER:StartUp.APair*:StartUp.FiveScans*:StartUp.EdgesTell*:StartUp.AHill*"
  GTEST_FILTER="$GTEST_FILTER:StartUp.AMotorwayAt*:StartUp.CarriedAt*:StartUp.ATurnThat*"
  GTEST_FILTER="$GTEST_FILTER:MotionMeasurements.DecidesThe*:WeakConstraint.*:HardPlaces.AnOpenField*:LidarOdometry.AnEmptyScan*"
  GTEST_FILTER="$GTEST_FILTER:RangeNoise.IsThat*:Detector.ForgetsScans*:PointcloudComparison.AgreesWith*"
  # The same code as the other tests of random scenes, of runs along own odometry, and of interrupts.
  GTEST_FILTER="$GTEST_FILTER:RandomScene.NothingIs*:RandomScene.TheSensorTouches*:RandomScene.SeedsDiffer*:Scene.EverySceneHas*"
  GTEST_FILTER="$GTEST_FILTER:Odometry.TakesMeasurements*:Odometry.InterruptedIn*:MovingObjects.AnIdIs*"
  GTEST_FILTER="$GTEST_FILTER:BenchmarkSpeed.TellsEvery*:Odometry.WritesThe*:Odometry.Replaces*:DetectTest.EstimatesATrajectory*"
  GTEST_FILTER="$GTEST_FILTER:Simulate.WhatIsFinishedWhen*:Simulate.ItsTruth*:ResumeTest.AfterAKill*:DetectProbability.IsWritten*"
  GTEST_FILTER="$GTEST_FILTER:DetectObjectsTest.TellsOf*:DetectObjectsTest.Overwriting*:DetectTest.InfoTellsHow*:Usage.WorkGoes*"
  GTEST_FILTER="$GTEST_FILTER:Odometry.OfCompensated*:Odometry.Overwrites*:EvaluateTrajectory.Of*:EvaluateTrajectory.Not*"
  GTEST_FILTER="$GTEST_FILTER:MotionProbability.Sums*:StandingTest.ABoxThatMoves*:OnlineDetector.KeepsThe*:RandomScene.HitsHave*"
  GTEST_FILTER="$GTEST_FILTER:LongDrives.*:MotionMeasurements.AMotion*" ;;
tsan) # what runs on several threads, but for Embree's own, which are not instrumented
  GTEST_FILTER='*Threads*:*OneThread*:Compensate.*:RestoreMeasuredRays.*:PointcloudComparison.*:Walls.*:Mdlidar*'
  # These cast rays, take minutes, or drive as DetectionRunThreads does.
  GTEST_FILTER="$GTEST_FILTER:-Benchmark*:Simulate.*:DetectTest.*:LidarOdometry.TheSame*"
  # The same code on several threads as SideBySideGivesTheSame, in four minutes more.
  GTEST_FILTER="$GTEST_FILTER:OnlineDetectorThreads.IsOdometry*:OnlineDetectorThreads.AnyNumber*:OnlineDetectorThreads.CatchingUp*"
  GTEST_FILTER="$GTEST_FILTER:OnlineDetectorThreads.SideBySideTheLabels*:OnlineDetectorThreads.AScanThat*" ;;
*)
  echo "scripts/check_sanitizer.sh: $1: no such preset; use asan or tsan" >&2
  exit 2 ;;
esac
export GTEST_FILTER GTEST_BRIEF=1
export ASAN_OPTIONS=detect_stack_use_after_return=1:strict_string_checks=1
export LSAN_OPTIONS="suppressions=$PWD/tests/leaks_of_others.txt:print_suppressions=0"
export UBSAN_OPTIONS=print_stacktrace=1
export TSAN_OPTIONS=halt_on_error=1
cmake --preset "$1"
cmake --build --preset "$1" -j "$jobs" --target mapless_tests
# The largest first: they take longest.
ls -S "build/$1"/tests/*_tests | xargs -n 1 -P "$jobs" sh -c 'exec "$0"'
