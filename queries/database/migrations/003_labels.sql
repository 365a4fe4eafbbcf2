-- A case under every name that studies have for it, and the peak that levels are judged by.

COMMENT ON TABLE cases IS 'One row per case and label: a case that studies name twice has a row for each; results appear under every label';
COMMENT ON COLUMN axles.behind_first_axle_m IS 'Distance behind the leading axle, m; NULL in runs of versions that did not say';

ALTER TABLE bands ADD COLUMN peak_mean_square DOUBLE;
COMMENT ON COLUMN bands.peak_mean_square IS 'Largest mean square of all bands and contributions of this quantity at this receiver: (m/s)^2 for velocity, N^2 for wheel_rail_force';
UPDATE bands SET peak_mean_square = peaks.peak
FROM (
    SELECT source, unit_id, case_id, approach, quantity, receiver, offset_m, averaging, max(mean_square) AS peak
    FROM bands GROUP BY ALL
) AS peaks
WHERE bands.source IS NOT DISTINCT FROM peaks.source AND bands.unit_id IS NOT DISTINCT FROM peaks.unit_id
    AND bands.case_id = peaks.case_id AND bands.approach = peaks.approach
    AND bands.quantity IS NOT DISTINCT FROM peaks.quantity AND bands.receiver IS NOT DISTINCT FROM peaks.receiver
    AND bands.offset_m IS NOT DISTINCT FROM peaks.offset_m AND bands.averaging IS NOT DISTINCT FROM peaks.averaging;
