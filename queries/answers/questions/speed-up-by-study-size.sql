-- How many times less than the reference does an approach cost, as the cases of a study add up and share work?
WITH placed AS (
    SELECT case_id, row_number() OVER (ORDER BY soil, track, train, unevenness, speed_kmh) AS place FROM cases
), unit AS (
    SELECT source, unit_id, sum(cpu_s) AS cpu_s, any_value(host_class) AS host_class FROM unit_costs GROUP BY ALL
), first_need AS (  -- work that several cases share is paid by the first of them
    SELECT approach, source, unit_id, min(place) AS place FROM current_units JOIN placed USING (case_id) GROUP BY ALL
), added AS (
    SELECT approach, place, sum(cpu_s) AS cpu_s, max(host_class) AS host_class, min(host_class) AS other_class
    FROM first_need JOIN unit USING (source, unit_id) GROUP BY ALL
), total AS (
    SELECT approach, place AS cases, sum(coalesce(cpu_s, 0)) OVER (PARTITION BY approach ORDER BY place) AS cpu_s,
        max(host_class) OVER (PARTITION BY approach ORDER BY place) AS host_class,
        min(other_class) OVER (PARTITION BY approach ORDER BY place) AS other_class
    FROM placed CROSS JOIN (SELECT DISTINCT approach FROM current_units) LEFT JOIN added USING (approach, place)
)
SELECT total.cases, total.approach, round(total.cpu_s, 3) AS cpu_s, round(against.cpu_s, 3) AS reference_cpu_s,
    CASE WHEN total.host_class = total.other_class AND against.host_class = against.other_class
        AND total.host_class = against.host_class THEN round(against.cpu_s / total.cpu_s, 2) END AS speed_up
FROM total JOIN total AS against USING (cases)
WHERE against.approach = (SELECT arg_max(reference, sequence) FROM runs) AND total.approach <> against.approach
ORDER BY total.cases, total.approach
